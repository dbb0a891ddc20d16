// SPDX-License-Identifier: MIT
#include "limber/measure/rig.hpp"

#include <gtest/gtest.h>

#include "check_jacobian.hpp"
#include "limber/core/so3.hpp"
#include "rigs.hpp"

namespace limber {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::Generator;

Vector3d centre_in_body(const MountedCamera& camera) { return camera.T_cam_body.inverse().p; }

TEST(Mount, BothCamerasStandAsThetaSays) {
  Generator generator(1);
  for (const auto& [name, calibration] : testing::all_rigs(generator)) {
    const MountedRig rig = mount(calibration);
    const Pose T_cam1_cam0 = rig[1].T_cam_body * rig[0].T_cam_body.inverse();
    const Pose expected = pose_from_rig(calibration.theta);
    EXPECT_LE((T_cam1_cam0.R - expected.R).norm(), 1e-14) << name;
    EXPECT_LE((T_cam1_cam0.p - expected.p).norm(), 1e-14) << name;
    const Pose T_body_cam0 = body_from_cam0(calibration);
    EXPECT_LE((T_body_cam0.R - rig[0].T_cam_body.R.transpose()).norm(), 1e-14) << name;
    EXPECT_LE((T_body_cam0.p - centre_in_body(rig[0])).norm(), 1e-14) << name;
  }
}

TEST(Mount, KeepsTheIntrinsicsOfEachCamera) {
  Generator generator(2);
  const StereoCalibration calibration = testing::random_calibration(
      generator, BodyFrame::kCam0, testing::paper_camera(), testing::euroc_camera(), 0.1);
  const MountedRig rig = mount(calibration);
  EXPECT_EQ(rig[0].camera.fu, testing::paper_camera().fu);
  EXPECT_EQ(rig[1].camera.fu, testing::euroc_camera().fu);
}

TEST(Mount, ImuBodyCarriesTheLeftCameraWhereItsCalibrationSays) {
  Generator generator(3);
  const StereoCalibration calibration = testing::random_calibration(
      generator, BodyFrame::kImu, testing::paper_camera(), testing::paper_camera(), 0.1);
  const Pose identity = mount(calibration)[0].T_cam_body * calibration.T_body_cam0;
  EXPECT_LE((identity.R - Matrix3d::Identity()).norm(), 1e-14);
  EXPECT_LE(identity.p.norm(), 1e-14);
}

TEST(Mount, LeftCameraBodyIsTheLeftCameraWhateverTheCalibrationCarries) {
  Generator generator(4);
  const StereoCalibration calibration = testing::random_calibration(
      generator, BodyFrame::kCam0, testing::paper_camera(), testing::paper_camera(), 0.1);
  const MountedRig rig = mount(calibration);
  EXPECT_EQ(rig[0].T_cam_body.R, Matrix3d::Identity());
  EXPECT_EQ(rig[0].T_cam_body.p, Vector3d::Zero());
}

TEST(Mount, MiddleBodyStandsHalfwayBetweenTheCamerasInPositionAndAttitude) {
  Generator generator(5);
  for (const double turn : {0.0, 1e-8, 0.2, 1.0}) {
    const StereoCalibration calibration = testing::random_calibration(
        generator, BodyFrame::kMiddleOfBaseline, testing::paper_camera(), testing::paper_camera(), turn);
    const MountedRig rig = mount(calibration);
    EXPECT_LE((centre_in_body(rig[0]) + centre_in_body(rig[1])).norm(), 1e-14);
    // From cam0 to the body and from the body to cam1 it is the same turn.
    EXPECT_LE((rig[0].T_cam_body.R.transpose() - rig[1].T_cam_body.R).norm(), 1e-14);
  }
}

TEST(Mount, OnlyTheMiddleBodyMakesTheLeftCameraDependOnTheta) {
  Generator generator(6);
  for (const auto& [name, calibration] : testing::all_rigs(generator)) {
    const MountedRig rig = mount(calibration);
    const bool middle = calibration.body == BodyFrame::kMiddleOfBaseline;
    EXPECT_EQ(rig[0].depends_on_theta, middle) << name;
    EXPECT_TRUE(rig[1].depends_on_theta) << name;
    EXPECT_EQ(rig[0].J_rotation.isZero(0.0) && rig[0].J_translation.isZero(0.0), !middle) << name;
  }
}

TEST(Mount, JacobiansMatchCentralDifferences) {
  Generator generator(7);
  for (const auto& [name, calibration] : testing::all_rigs(generator)) {
    SCOPED_TRACE(name);
    const MountedRig rig = mount(calibration);
    for (const std::size_t cam : {0U, 1U}) {
      MatrixXd J(6, 6);
      J << rig[cam].J_rotation, rig[cam].J_translation;
      testing::check_jacobian(
          J,
          [&, theta = calibration.theta, c = calibration](const VectorXd& dtheta) mutable {
            c.theta = theta + dtheta;
            const Pose moved = mount(c)[cam].T_cam_body;
            VectorXd out(6);
            out << so3_log(moved.R * rig[cam].T_cam_body.R.transpose()), moved.p - rig[cam].T_cam_body.p;
            return out;
          },
          1e-8);
    }
  }
}

}  // namespace
}  // namespace limber
