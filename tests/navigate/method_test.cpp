// SPDX-License-Identifier: MIT
#include "limber/navigate/method.hpp"

#include <gtest/gtest.h>

#include "message_of.hpp"

namespace limber {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using testing::message_of;

RigParameters rig() {
  RigParameters theta;
  theta << 0.1, -0.2, 0.3, -1.2, 0.9, -0.8;
  return theta;
}

TEST(Method, NamesComeBackFromTheirStrings) {
  for (const Method method : kAllMethods) {
    EXPECT_EQ(method_from_string(to_string(method)), method);
  }
  EXPECT_EQ(method_from_string("ekf-full"), Method::kEkfFull);
  EXPECT_EQ(method_from_string("LCEKF"), Method::kLcekf);
  EXPECT_EQ(to_string(Method::kMonoLeft), "mono-left");
}

TEST(Method, AnUnknownNameIsRefusedWithTheKnownOnes) {
  for (const std::string name : {"", "EKV", "lcekf ", "kalman"}) {
    const std::string message = message_of([&] { (void)method_from_string(name); });
    EXPECT_NE(message.find("'" + name + "'"), std::string::npos) << message;
    for (const Method method : kAllMethods) {
      EXPECT_NE(message.find(to_string(method)), std::string::npos) << message;
    }
  }
}

TEST(ConstraintSet, ComesBackFromItsString) {
  for (const std::string text :
       {"full", "none", "rotation", "rotation+direction", "ax", "tz", "ax,ay,tx", "ax,ay,az,tx,ty,tz",
        "full,dt1", "rotation,fu1,imu-tx", "rotation+direction,dt0", "tx,radial0", "dt0,dt1"}) {
    EXPECT_EQ(to_string(constraint_set_from_string(text)), text);
  }
}

TEST(ConstraintSet, AListIsPutInOrder) {
  EXPECT_EQ(to_string(constraint_set_from_string("tx,ax")), "ax,tx");
  EXPECT_EQ(to_string(constraint_set_from_string("ty,ty")), "ty");
  EXPECT_EQ(to_string(constraint_set_from_string("theta")), "ax,ay,az,tx,ty,tz");
  EXPECT_EQ(to_string(constraint_set_from_string("none,dt1")), "dt1");
  EXPECT_EQ(to_string(constraint_set_from_string("full,imu,intrinsics1")),
            "full,fu1,fv1,cu1,cv1,radial1,imu-ax,imu-ay,imu-az,imu-tx,imu-ty,imu-tz");
}

TEST(ConstraintSet, AnythingElseIsRefusedWithWhatWasExpected) {
  for (const std::string text :
       {"", "all", "ax,", ",ax", "ax,,ay", "ax ay", "ax, ay", "none,ax", "rotation,tx", "bx", "full,",
        "dt1,full", "full,theta", "full,dt", "full,full"}) {
    const std::string message = message_of([&] { (void)constraint_set_from_string(text); });
    EXPECT_NE(message.find("'" + text + "'"), std::string::npos) << message;
    EXPECT_NE(message.find("rotation+direction"), std::string::npos) << message;
  }
}

TEST(ConstraintSet, TakesAnyCaseAndNamesWhatWasMeant) {
  EXPECT_EQ(to_string(constraint_set_from_string("Full,DT1")), "full,dt1");
  EXPECT_EQ(to_string(constraint_set_from_string("AX,ty")), "ax,ty");
  const auto meant = [](const std::string& text) {
    return message_of([&] { (void)constraint_set_from_string(text); });
  };
  EXPECT_NE(meant("rotation+directon").find("(did you mean rotation+direction?)"), std::string::npos);
  EXPECT_NE(meant("ful").find("(did you mean full?)"), std::string::npos);
  EXPECT_NE(meant("full,dt11").find("'full,dt11' (did you mean dt1?)"), std::string::npos);
  EXPECT_NE(meant("full,intrinsic1").find("(did you mean intrinsics1?)"), std::string::npos);
  EXPECT_EQ(meant("everything").find("did you mean"), std::string::npos);
}

TEST(PlausibleError, IsATenthOfADegreeAndATwentiethOfTheBaseline) {
  const RigParameters error = plausible_error(2.0);
  EXPECT_LE((error.head<3>() - Vector3d::Constant(0.1 * M_PI / 180.0)).norm(), 1e-15);
  EXPECT_LE((error.tail<3>() - Vector3d::Constant(0.1)).norm(), 1e-15);
}

MatrixXd directions(const std::string& set) {
  return constraint_directions(constraint_set_from_string(set), rig());
}

TEST(ConstraintDirections, AreOnePlausibleErrorEach) {
  const RigParameters scale = plausible_error(rig().tail<3>().norm());
  EXPECT_EQ(directions("full"), MatrixXd(scale.asDiagonal()));
  EXPECT_EQ(directions("rotation"), MatrixXd(MatrixXd(scale.asDiagonal()).leftCols<3>()));
  EXPECT_EQ(directions("none").rows(), 6);
  EXPECT_EQ(directions("none").cols(), 0);
  const MatrixXd listed = directions("ay,tx,tz");
  ASSERT_EQ(listed.cols(), 3);
  EXPECT_EQ(listed.col(0), scale(1) * RigParameters::Unit(1));
  EXPECT_EQ(listed.col(1), scale(3) * RigParameters::Unit(3));
  EXPECT_EQ(listed.col(2), scale(5) * RigParameters::Unit(5));
}

TEST(ConstraintSet, OfVisionAloneLeavesTheLengthOfTheBaselineOutUnlessToldOtherwise) {
  EXPECT_EQ(to_string(default_constraints(MotionModel::kImu)), "full");
  EXPECT_EQ(to_string(default_constraints(MotionModel::kOdometry)), "full");
  EXPECT_EQ(to_string(default_constraints(MotionModel::kConstantVelocity)), "rotation+direction");
}

TEST(ConstraintDirections, AFullListIsFull) {
  EXPECT_EQ(directions("ax,ay,az,tx,ty,tz"), directions("full"));
}

TEST(ConstraintDirections, RotationAndDirectionLeaveOutTheLengthOfTheBaselineAndNothingElse) {
  const RigParameters scale = plausible_error(rig().tail<3>().norm());
  const MatrixXd scaled = scale.cwiseInverse().asDiagonal() * directions("rotation+direction");
  ASSERT_EQ(scaled.cols(), 5);
  EXPECT_LE((scaled.transpose() * scaled - MatrixXd::Identity(5, 5)).norm(), 1e-14);
  RigParameters length = RigParameters::Zero();
  length.tail<3>() = rig().tail<3>().normalized();
  EXPECT_LE((scaled.transpose() * length).norm(), 1e-14);
}

}  // namespace
}  // namespace limber
