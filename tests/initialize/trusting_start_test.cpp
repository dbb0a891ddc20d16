// SPDX-License-Identifier: MIT
// A start of `adaptive` trusts the rig where the window does not contradict it, and keeps the start without
// that trust beside it.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>

#include "initialize/started.hpp"
#include "limber/core/angle.hpp"
#include "limber/navigate/navigator.hpp"

namespace limber {
namespace {

using testing::at_once;
using testing::make_scene;
using testing::of_seed;
using testing::options_of;
using testing::Scene;
using testing::SceneOptions;
using testing::Started;

Started started(const SceneOptions& of, Method method) {
  const Scene scene = make_scene(of);
  return testing::start(scene, options_of(scene, method), at_once());
}

double velocity_sigma(const InitialState& initial) {
  return std::sqrt(
      initial.body_covariance.block<3, 3>(StateLayout::kVelocity, StateLayout::kVelocity).trace());
}

TEST(TrustingStart, OfASoundRigIsAsSureAsThatOfEkfAndHasTheOtherBesideIt) {
  for (const std::uint64_t seed : {21, 22, 23}) {
    const InitialState initial = started(of_seed(seed), Method::kAdaptive).result.initial;
    ASSERT_TRUE(initial.distrusting) << seed;
    const InitialState distrusting = started(of_seed(seed), Method::kLcekf).result.initial;
    EXPECT_EQ(initial.distrusting->nav.v_world_body, distrusting.nav.v_world_body) << seed;
    EXPECT_EQ(initial.distrusting->body_covariance, distrusting.body_covariance) << seed;
    EXPECT_FALSE(initial.distrusting->distrusting) << seed;
    EXPECT_LT(velocity_sigma(initial), 0.5 * velocity_sigma(distrusting)) << seed;
  }
}

TEST(TrustingStart, IsForTheAdaptiveMethodAlone) {
  for (const Method method : {Method::kEkf, Method::kLcekf, Method::kEkfFull}) {
    EXPECT_FALSE(started(of_seed(21), method).result.initial.distrusting) << to_string(method);
  }
}

/// A tenth of a degree, a hundredth of the baseline, a rig that shakes: that of lcekf, to the last bit.
TEST(TrustingStart, IsNoneWhereTheWindowContradictsTheRig) {
  const auto axis = [](Eigen::Index k, double size) {
    RigParameters error = RigParameters::Zero();
    error[k] = size;
    return error;
  };
  const RigParameters turned = axis(0, 0.1 / kToDegrees), moved = axis(4, 0.003),
                      shaken = axis(1, 0.3 / kToDegrees);
  for (const auto& error : {std::function<RigParameters(double)>([&](double) { return turned; }),
                            std::function<RigParameters(double)>([&](double) { return moved; }),
                            std::function<RigParameters(double)>(
                                [&](double t) { return RigParameters(shaken * std::sin(20.0 * t)); })}) {
    SceneOptions how = of_seed(24);
    how.theta_error = error;
    const InitialState initial = started(how, Method::kAdaptive).result.initial;
    EXPECT_FALSE(initial.distrusting);
    EXPECT_EQ(initial.body_covariance, started(how, Method::kLcekf).result.initial.body_covariance);
  }
}

/// On a train no acceleration tells the scale. Where the time was over, a start that had trusted the rig had
/// it from nothing: 11 m off in 750 m.
TEST(TrustingStart, IsThereWhenTheTimeIsOverAndNothingSpeaksAgainstTheRig) {
  StartOptions how;
  how.open_scale_sigma = 1e-6;
  how.longest_s = how.longest_moving_s = 2.0;
  const Scene sound = make_scene(of_seed(21));
  const Started found = testing::start(sound, options_of(sound, Method::kAdaptive), how);
  ASSERT_EQ(found.report.status, StartStatus::kTimedOut);
  ASSERT_TRUE(found.result.initial.distrusting);
  EXPECT_LT(velocity_sigma(found.result.initial), 0.5 * velocity_sigma(*found.result.initial.distrusting));

  SceneOptions turned = of_seed(21);
  turned.theta_error = [](double) { return RigParameters(0.1 / kToDegrees * RigParameters::Unit(0)); };
  const Scene bent = make_scene(turned);
  EXPECT_FALSE(testing::start(bent, options_of(bent, Method::kAdaptive), how).result.initial.distrusting);
}

TEST(TrustingStart, BeginsANavigatorWhoseCheckpointTrustsNothing) {
  const Scene scene = make_scene(of_seed(21));
  const NavigatorOptions options = options_of(scene, Method::kAdaptive);
  const InitialState initial = testing::start(scene, options, at_once()).result.initial;
  ASSERT_TRUE(initial.distrusting);
  const Navigator navigator(options, scene.calibration, initial);
  EXPECT_EQ(navigator.estimate().nav().v_world_body, initial.nav.v_world_body);
  InitialState broken = initial;
  auto other = std::make_shared<InitialState>(*initial.distrusting);
  other->nav.v_world_body.x() = std::nan("");
  broken.distrusting = other;
  EXPECT_THROW(Navigator(options, scene.calibration, broken), std::invalid_argument);
}

}  // namespace
}  // namespace limber
