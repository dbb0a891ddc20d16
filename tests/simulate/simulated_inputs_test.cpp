// SPDX-License-Identifier: MIT
// The IMU and the odometer of a simulated recording.
#include "limber/simulate/simulator.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "limber/core/errors.hpp"
#include "limber/core/so3.hpp"
#include "limber/datasets/read_recording.hpp"
#include "limber/datasets/track_log.hpp"
#include "limber/measure/rig.hpp"
#include "limber/simulate/scenario_file.hpp"
#include "real_data.hpp"
#include "simulate/recordings.hpp"
#include "simulate/scenarios.hpp"
#include "source_folder.hpp"

namespace limber {
namespace {

using Eigen::Vector3d;
using testing::brief;
using testing::shipped;

TEST(SimulatedImu, AddsBiasAndWhiteNoiseOfTheStatedSizeToTheIdealReading) {
  Scenario s;
  const Recording noisy = simulate(s, 1);
  s.noise.accel = s.noise.gyro = 0.0;
  s.initial.bias_accel = s.initial.bias_gyro = 0.0;
  const Recording ideal = simulate(s, 1);
  Vector3d mean_gyro = Vector3d::Zero(), mean_accel = Vector3d::Zero();
  double square_gyro = 0.0, square_accel = 0.0;
  const double n = static_cast<double>(noisy.imu.size());
  for (std::size_t k = 0; k < noisy.imu.size(); ++k) {
    const Vector3d gyro =
        noisy.imu[k].omega_imu - ideal.imu[k].omega_imu - noisy.truth.motion.states[k].bias_gyro;
    const Vector3d accel =
        noisy.imu[k].accel_imu - ideal.imu[k].accel_imu - noisy.truth.motion.states[k].bias_accel;
    mean_gyro += gyro / n;
    mean_accel += accel / n;
    square_gyro += gyro.squaredNorm() / (3.0 * n);
    square_accel += accel.squaredNorm() / (3.0 * n);
  }
  const double gyro = 0.5 * M_PI / 180.0, accel = 0.1;  // per sample, 100 Hz
  EXPECT_LT(mean_gyro.cwiseAbs().maxCoeff(), 5.0 * gyro / std::sqrt(n));
  EXPECT_LT(mean_accel.cwiseAbs().maxCoeff(), 5.0 * accel / std::sqrt(n));
  EXPECT_NEAR(std::sqrt(square_gyro), gyro, 5.0 * gyro / std::sqrt(6.0 * n));
  EXPECT_NEAR(std::sqrt(square_accel), accel, 5.0 * accel / std::sqrt(6.0 * n));
  ASSERT_TRUE(noisy.imu_noise.has_value());
  EXPECT_NEAR(noisy.imu_noise->gyro_density, gyro / 10.0, 1e-15);
  EXPECT_NEAR(noisy.imu_noise->accel_density, accel / 10.0, 1e-15);
  EXPECT_FALSE(ideal.imu_noise.has_value());
  EXPECT_EQ(ideal.notes.size(), 1u);
}

// The trapezoidal rule on samples of 1 kHz.
TEST(SimulatedImu, LeadsBackToTheGroundTruthWhenItIsFreeOfNoise) {
  Scenario s = shipped("drone_none");
  s.imu_rate = 1000.0;
  s.noise.accel = s.noise.gyro = 0.0;
  s.initial.bias_accel = s.initial.bias_gyro = 0.0;
  s.duration = 20.0;
  const Recording recording = simulate(s, 1);
  GroundTruthState state = recording.truth.motion.states.front();
  for (std::size_t k = 1; k < recording.imu.size(); ++k) {
    const ImuSample &a = recording.imu[k - 1], &b = recording.imu[k];
    const double dt = static_cast<double>(b.t_ns - a.t_ns) * 1e-9;
    const Eigen::Matrix3d R_next = state.R_world_body * so3_exp(0.5 * dt * (a.omega_imu + b.omega_imu));
    const Vector3d acceleration =
        0.5 * (state.R_world_body * a.accel_imu + R_next * b.accel_imu) - 9.81 * Vector3d::UnitZ();
    state.p_world_body += dt * state.v_world_body + 0.5 * dt * dt * acceleration;
    state.v_world_body += dt * acceleration;
    state.R_world_body = R_next;
  }
  const GroundTruthState& truth = recording.truth.motion.states.back();
  EXPECT_LT((state.p_world_body - truth.p_world_body).norm(), 1e-3);
  EXPECT_LT((state.v_world_body - truth.v_world_body).norm(), 1e-4);
  EXPECT_LT(so3_log(state.R_world_body.transpose() * truth.R_world_body).norm(), 1e-5);
}

// 200 runs: five standard deviations of an estimated variance.
TEST(SimulatedBiases, AreDrawnFromTheInitialSigmasAndWalkAsStated) {
  Scenario s = brief(1.0);
  s.world.points = 0;
  s.noise.accel_walk = 0.2;
  s.noise.gyro_walk = 0.1;
  double start_gyro = 0.0, start_accel = 0.0, walk_gyro = 0.0, walk_accel = 0.0;
  constexpr int kRuns = 200, kValues = 3 * kRuns;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    const Recording recording = simulate(s, 1, run);
    const GroundTruthState &first = recording.truth.motion.states.front(),
                           &last = recording.truth.motion.states.back();
    start_gyro += first.bias_gyro.squaredNorm() / kValues;
    start_accel += first.bias_accel.squaredNorm() / kValues;
    walk_gyro += (last.bias_gyro - first.bias_gyro).squaredNorm() / kValues;
    walk_accel += (last.bias_accel - first.bias_accel).squaredNorm() / kValues;
  }
  const double relative = 5.0 * std::sqrt(2.0 / kValues);
  EXPECT_NEAR(start_gyro / 1e-6, 1.0, relative);
  EXPECT_NEAR(start_accel / 1e-4, 1.0, relative);
  EXPECT_NEAR(walk_gyro / 0.01, 1.0, relative);
  EXPECT_NEAR(walk_accel / 0.04, 1.0, relative);
}

TEST(SimulatedOdometry, IsVelocityAndRateOfTheBodyPlusNoise) {
  Scenario s = shipped("drone_none");
  s.odometry = OdometryScenario{.rate = 40.0, .velocity = 0.05, .angular_rate = 0.01};
  const Recording recording = simulate(s, 1);
  const SplineTrajectory trajectory = make_trajectory(s, 1);
  ASSERT_EQ(recording.odometry.size(), 1201u);
  double velocity = 0.0, rate = 0.0;
  for (const OdometrySample& sample : recording.odometry) {
    const Kinematics truth = trajectory.at(static_cast<double>(sample.t_ns) * 1e-9);
    velocity +=
        (sample.v_body - truth.T_world_body.R.transpose() * truth.v_world_body).squaredNorm() / 3603.0;
    rate += (sample.omega_body - truth.omega_body).squaredNorm() / 3603.0;
  }
  EXPECT_NEAR(std::sqrt(velocity), 0.05, 0.05 * 5.0 / std::sqrt(2.0 * 3603.0));
  EXPECT_NEAR(std::sqrt(rate), 0.01, 0.01 * 5.0 / std::sqrt(2.0 * 3603.0));
  EXPECT_EQ(recording.odometry_noise.value().sigma_v, Vector3d::Constant(0.05));
}

}  // namespace
}  // namespace limber
