// SPDX-License-Identifier: MIT
#include "limber/initialize/initialize.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "window.hpp"

namespace limber {
namespace {

using Eigen::Vector3d;
using testing::make_window;
using testing::SceneOptions;
using testing::Window;
using L = StateLayout;

constexpr double kGravity = 9.81;

/// The scene's rig starts level: the angle between the body's z axis and the vertical [rad].
double tilt_of(const Eigen::Matrix3d& R) { return std::acos(std::clamp(R(2, 2), -1.0, 1.0)); }

TEST(Initialize, StartsAtTheOriginAtTheFirstFrameWithoutYaw) {
  const Window window = make_window({});
  const InitialState start =
      initialize(window.start(), window.scene.calibration, MotionModel::kImu, kGravity);
  EXPECT_EQ(start.nav.t_ns, window.scene.frames.front().t_ns);
  EXPECT_EQ(start.nav.T_world_body.p, Vector3d::Zero());
  const Vector3d forward = start.nav.T_world_body.R * body_from_cam0(window.scene.calibration).R.col(2);
  EXPECT_NEAR(forward.y(), 0.0, 1e-12);
  EXPECT_GT(forward.x(), 0.0);
}

TEST(Initialize, OfAMovingRigIsAsSureAsItSays) {
  constexpr int kRuns = 40;
  double nees = 0.0;
  for (int k = 0; k < kRuns; ++k) {
    const Window window = make_window(testing::longer_baseline(static_cast<std::uint64_t>(k) + 1));
    const InitialState start =
        initialize(window.start(), window.scene.calibration, MotionModel::kImu, kGravity);
    const Vector3d e = window.v_body() - start.nav.T_world_body.R.transpose() * start.nav.v_world_body;
    const Eigen::Matrix3d R = start.nav.T_world_body.R;
    const Eigen::Matrix3d P =
        R.transpose() * start.body_covariance.block<3, 3>(L::kVelocity, L::kVelocity) * R;
    nees += e.dot(P.llt().solve(e)) / 3.0;
    EXPECT_EQ(Eigen::LLT<Eigen::MatrixXd>(start.body_covariance).info(), Eigen::Success);
    EXPECT_LE(e.norm(), 0.3 * window.v_body().norm()) << k;
    EXPECT_LE(tilt_of(start.nav.T_world_body.R), 0.05) << k;
  }
  EXPECT_LE(nees / kRuns, 1.5);
  EXPECT_GE(nees / kRuns, 0.1);
}

/// A second of standing still, level, with a gyro bias.
Window still_window(const Vector3d& bias_gyro) {
  Window window = make_window({});
  const StereoFrame first = window.scene.frames.front();
  for (StereoFrame& frame : window.scene.frames) {
    const std::int64_t t_ns = frame.t_ns;
    frame = first;
    frame.t_ns = t_ns;
  }
  for (ImuSample& sample : window.imu) {
    sample.omega_imu = bias_gyro;
    sample.accel_imu << 0.0, 0.0, kGravity;
  }
  return window;
}

TEST(Initialize, OfAStillRigTakesItsRateForTheBias) {
  const Vector3d bias(0.01, -0.02, 0.005);
  const Window window = still_window(bias);
  const InitialState start =
      initialize(window.start(), window.scene.calibration, MotionModel::kImu, kGravity);
  EXPECT_LE((start.nav.bias_gyro - bias).norm(), 1e-12);
  EXPECT_EQ(start.nav.v_world_body, Vector3d::Zero());
  EXPECT_LE(tilt_of(start.nav.T_world_body.R), 1e-6);
  EXPECT_LE(start.body_covariance(L::kVelocity, L::kVelocity), 1e-3);
}

TEST(Initialize, WithoutCommonPointsSaysThatTheVelocityIsUnknown) {
  Window window = make_window({});
  for (std::size_t k = 1; k < window.scene.frames.size(); ++k) {
    window.scene.frames[k].observations.clear();
  }
  for (const MotionModel motion : {MotionModel::kImu, MotionModel::kConstantVelocity}) {
    const InitialState start = initialize(window.start(), window.scene.calibration, motion, kGravity);
    EXPECT_EQ(start.nav.v_world_body, Vector3d::Zero());
    EXPECT_GE(start.body_covariance(L::kVelocity, L::kVelocity), 1.0);
  }
}

TEST(Initialize, WithoutImuTakesTheCamerasWordForTheVelocityAndDoubtsIt) {
  SceneOptions options;
  options.motion = MotionModel::kConstantVelocity;
  options.noise = false;
  const Window window = make_window(options);
  const InitialState start =
      initialize(window.start(), window.scene.calibration, MotionModel::kConstantVelocity, kGravity);
  const double speed = window.v_body().norm();
  EXPECT_NEAR(start.nav.v_world_body.norm(), speed, 0.01 * speed);
  EXPECT_GE(std::sqrt(start.body_covariance(L::kVelocity, L::kVelocity)), 0.05 * speed);
}

TEST(Initialize, NeedsAFrameAndWithAnImuItsSamples) {
  const Window window = make_window({});
  EXPECT_THROW((void)initialize({}, window.scene.calibration, MotionModel::kImu, kGravity),
               std::invalid_argument);
  EXPECT_THROW(
      (void)initialize({window.scene.frames, {}, {}}, window.scene.calibration, MotionModel::kImu, kGravity),
      std::invalid_argument);
}

}  // namespace
}  // namespace limber
