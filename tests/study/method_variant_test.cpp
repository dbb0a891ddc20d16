// SPDX-License-Identifier: MIT
#include "limber/study/method_variant.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

namespace limber {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string refusal_of_text(const std::string& text) {
  try {
    (void)method_variants_from_string(text);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

std::vector<std::string> labels_of(const std::string& text) {
  std::vector<std::string> labels;
  for (const MethodVariant& variant : method_variants_from_string(text)) {
    labels.push_back(to_string(variant));
  }
  return labels;
}

TEST(MethodVariant, ReadsWhatItWrites) {
  for (const std::string text :
       {"ekf", "ekf-full", "oracle", "lcekf", "lcekf:full", "lcekf:none", "lcekf:rotation+direction",
        "lcekf:ax,tz", "mono-left:cartesian", "lcekf:rotation:cartesian", "ekf-full:walk=x10",
        "ekf-full:walk=x0.1", "lcekf:full,fu0,dt1", "ekf:estimate=dt0,imu:assume=dt0=0.005,imu-tx=0.01",
        "ekf:soften=cu1=2", "ekf-full:walk=0/0", "ekf-full:walk=5e-07/0.1", "ekf-full:cartesian:walk=x2"}) {
    EXPECT_EQ(to_string(method_variant_from_string(text)), text);
  }
}

TEST(MethodVariant, HoldsWhatTheTextSays) {
  const MethodVariant lcekf = method_variant_from_string("lcekf:tx,ty:cartesian");
  EXPECT_EQ(lcekf.method, Method::kLcekf);
  EXPECT_EQ(lcekf.landmarks, LandmarkKind::kCartesian);
  EXPECT_EQ(lcekf.constraints->listed, ParameterSet("011000"));
  const MethodVariant full = method_variant_from_string("ekf-full:walk=2e-5/20");
  EXPECT_TRUE(full.walk->absolute);
  EXPECT_EQ(full.walk->rotation, 2e-5);
  EXPECT_EQ(full.walk->translation, 20.0);
  EXPECT_FALSE(method_variant_from_string("ekf-full").walk);
  EXPECT_EQ(method_variant_from_string("ekf-full:walk=x100").walk->factor, 100.0);
}

TEST(MethodVariants, KeepTheParametersOfAListTogether) {
  EXPECT_THAT(labels_of("lcekf:ax,tx,ekf,lcekf:tz"), ElementsAre("lcekf:ax,tx", "ekf", "lcekf:tz"));
  EXPECT_THAT(labels_of("ekf:estimate=dt0=0.001,dt1:assume=dt0=0.005,fu1=1%,lcekf:full,intrinsics0,soft"),
              ElementsAre("ekf:estimate=dt0=0.001,dt1:assume=dt0=0.005,fu1=1%",
                          "lcekf:full,fu0,fv0,cu0,cv0,radial0", "soft"));
}

TEST(MethodVariants, RefuseEverythingElseAndSayWhy) {
  EXPECT_THAT(refusal_of_text("kalman"), HasSubstr("unknown method 'kalman', expected one of ekf"));
  EXPECT_THAT(refusal_of_text(""), HasSubstr("unknown method"));
  EXPECT_THAT(refusal_of_text("ekf,"), HasSubstr("unknown method"));
  EXPECT_THAT(refusal_of_text("ax"), HasSubstr("unknown method"));
  EXPECT_THAT(refusal_of_text("ekf:full"), HasSubstr("unknown option 'full', expected cartesian"));
  EXPECT_THAT(refusal_of_text("lcekf:everything"), HasSubstr("unknown constraint set 'everything'"));
  EXPECT_THAT(refusal_of_text("lcekf:walk=x10"), HasSubstr("only ekf-full lets theta walk"));
  for (const std::string walk : {"", "x", "10", "1/2/3", "-1/1", "x-1", "nan/1", "1e-6/"}) {
    EXPECT_THAT(refusal_of_text("ekf-full:walk=" + walk), HasSubstr("expected walk=xFACTOR")) << walk;
  }
  EXPECT_THAT(refusal_of_text("ekf:estimate="), HasSubstr("unknown parameter ''"));
  EXPECT_THAT(refusal_of_text("ekf:soften=dt2"), HasSubstr("unknown parameter 'dt2'"));
  EXPECT_THAT(refusal_of_text("ekf:assume=dt1"), HasSubstr("NAME=VALUE"));
  EXPECT_THAT(refusal_of_text("ekf,lcekf,ekf"), HasSubstr("'ekf': comes twice"));
}

}  // namespace
}  // namespace limber
