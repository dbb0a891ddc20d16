// SPDX-License-Identifier: MIT
#include "limber/sensors/calibration.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

#include "cameras.hpp"
#include "limber/core/so3.hpp"
#include "message_of.hpp"
#include "random_geometry.hpp"

namespace limber {
namespace {

using Eigen::Vector3d;
using testing::Generator;

RigParameters rig(double ax, double ay, double az, double tx, double ty, double tz) {
  RigParameters theta;
  theta << ax, ay, az, tx, ty, tz;
  return theta;
}

TEST(Rig, NominalOfThePaperPutsTheRightCameraTwoMetresToTheRight) {
  const Pose T_cam1_cam0 = pose_from_rig(rig(0.0, 0.0, 0.0, -2.0, 0.0, 0.0));
  const Vector3d centre_of_cam1_in_cam0 = T_cam1_cam0.inverse() * Vector3d::Zero();
  EXPECT_LE((centre_of_cam1_in_cam0 - Vector3d(2.0, 0.0, 0.0)).norm(), 1e-15);
}

TEST(Rig, RightCameraSeesAPointFurtherToTheLeft) {
  const Camera camera = testing::paper_camera();
  const Vector3d X_cam0(0.0, 0.0, 10.0);
  const auto left = project(camera, X_cam0);
  const auto right = project(camera, pose_from_rig(rig(0.0, 0.0, 0.0, -2.0, 0.0, 0.0)) * X_cam0);
  ASSERT_TRUE(left && right);
  // Disparity f b / z = 300 * 2 / 10.
  EXPECT_NEAR(left->uv.x() - right->uv.x(), 60.0, 1e-12);
  EXPECT_NEAR(left->uv.y() - right->uv.y(), 0.0, 1e-12);
}

TEST(Rig, RotatesByEulerAnglesZyx) {
  const Pose T_cam1_cam0 = pose_from_rig(rig(0.1, -0.2, 0.3, 0.0, 0.0, 0.0));
  EXPECT_LE((T_cam1_cam0.R - rotation_from_euler_zyx({0.1, -0.2, 0.3})).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(Rig, TurnAboutTheOpticalAxisTurnsTheRightImage) {
  // +90 degrees about z takes x to y: a point to the right in cam0 is below the centre in cam1.
  const Pose T_cam1_cam0 = pose_from_rig(rig(0.0, 0.0, 0.5 * M_PI, 0.0, 0.0, 0.0));
  const auto right = project(testing::paper_camera(), T_cam1_cam0 * Vector3d(1.0, 0.0, 10.0));
  ASSERT_TRUE(right);
  EXPECT_NEAR(right->uv.x(), 240.0, 1e-12);
  EXPECT_NEAR(right->uv.y(), 350.0, 1e-12);
}

TEST(Rig, ParametersComeBackFromThePose) {
  Generator generator(1);
  for (int k = 0; k < 100; ++k) {
    RigParameters theta;
    theta << testing::random_vector(generator, 1.5), testing::random_vector(generator, 3.0);
    EXPECT_LE((rig_from_pose(pose_from_rig(theta)) - theta).cwiseAbs().maxCoeff(), 1e-13)
        << theta.transpose();
  }
}

TEST(StereoCalibration, BaselineIsTheDistanceOfTheCentresWhateverTheRotation) {
  StereoCalibration calibration;
  calibration.theta = rig(0.4, -0.3, 0.2, -0.3, 0.0, 0.4);
  EXPECT_NEAR(calibration.baseline(), 0.5, 1e-15);
  EXPECT_NEAR(pose_from_rig(calibration.theta).inverse().p.norm(), 0.5, 1e-15);
}

TEST(StereoCalibration, WhatNoRigHasIsRefusedByName) {
  const double nan = std::nan("");
  const auto expect_refusal = [](const std::string& says,
                                 const std::function<void(StereoCalibration&)>& spoil) {
    StereoCalibration calibration;
    calibration.theta = rig(0.4, -0.3, 0.2, -0.3, 0.0, 0.4);
    EXPECT_NO_THROW(check_calibration(calibration));
    spoil(calibration);
    const std::string message = testing::message_of([&] { check_calibration(calibration); });
    EXPECT_NE(message.find(says), std::string::npos) << says << ": " << message;
  };
  expect_refusal("ay of theta is nan", [&](StereoCalibration& c) { c.theta(1) = nan; });
  expect_refusal("baseline is 0", [](StereoCalibration& c) { c.theta.tail<3>().setZero(); });
  expect_refusal("fu of cam0 is 0", [](StereoCalibration& c) { c.cam0.fu = 0.0; });
  expect_refusal("fv of cam1 is -400", [](StereoCalibration& c) { c.cam1.fv = -400.0; });
  expect_refusal("fu of cam1 is nan", [&](StereoCalibration& c) { c.cam1.fu = nan; });
  expect_refusal("cv of cam0 is nan", [&](StereoCalibration& c) { c.cam0.cv = nan; });
  expect_refusal("distortion coefficient of cam1", [&](StereoCalibration& c) {
    c.cam1.distortion = Equidistant{0.1, 0.0, 0.0, nan};
  });
  expect_refusal("cam0: expected a lens that sees straight ahead",
                 [](StereoCalibration& c) { c.cam0.distortion = Omni{.xi = -1.0}; });
  expect_refusal("T_body_cam0", [](StereoCalibration& c) { c.T_body_cam0.R.setZero(); });
  expect_refusal("T_body_cam0", [](StereoCalibration& c) { c.T_body_cam0.R(0, 0) = -1.0; });
  expect_refusal("T_body_cam0", [&](StereoCalibration& c) { c.T_body_cam0.p.y() = nan; });
  expect_refusal("time offset of cam1 is nan", [&](StereoCalibration& c) { c.time_offset_s[1] = nan; });
  expect_refusal("readout time of cam0 is nan", [&](StereoCalibration& c) { c.readout_time_s[0] = nan; });
}

TEST(StereoCalibration, AMountThatIsNotUsedMayBeAnything) {
  StereoCalibration calibration;
  calibration.theta = rig(0.0, 0.0, 0.0, -0.3, 0.0, 0.0);
  calibration.body = BodyFrame::kCam0;
  calibration.T_body_cam0.R.setZero();
  EXPECT_NO_THROW(check_calibration(calibration));
}

}  // namespace
}  // namespace limber
