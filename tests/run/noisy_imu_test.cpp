// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "check_covariance.hpp"
#include "limber/diagnose/run_summary.hpp"
#include "limber/run/run_recording.hpp"
#include "limber/simulate/simulator.hpp"
#include "shipped_scenario.hpp"

namespace limber {
namespace {

const Eigen::Vector3d kScales(1.01, 0.99, 1.01);  // of a gyro's axes that nobody calibrated

Recording with_scales(Recording recording, const Eigen::Vector3d& scales) {
  for (ImuSample& sample : recording.imu) {
    sample.omega_imu = sample.omega_imu.cwiseProduct(scales).eval();
  }
  return recording;
}

/// As noisy as an IMU of that many times the stated densities.
Recording with_noise(Recording recording, double times, unsigned seed) {
  constexpr double kGyro = 0.1 * std::numbers::pi / 180.0,
                   kAccel = 0.03;  // of a sample, scenarios/drone_none.yaml
  const double more = std::sqrt(times * times - 1.0);
  testing::Generator generator(seed);
  for (ImuSample& sample : recording.imu) {
    sample.omega_imu += more * kGyro * testing::random_normal(generator, 3);
    sample.accel_imu += more * kAccel * testing::random_normal(generator, 3);
  }
  return recording;
}

struct Flight {
  RunRecord record;
  RunSummary summary;
};

Flight fly(const Recording& recording, Method method, bool learn_imu_noise = true) {
  RunOptions options;
  options.method = method;
  options.learn_imu_noise = learn_imu_noise;
  Flight out;
  out.record = run_recording(recording, options, matched_frames(recording));
  out.summary = summarize(recording, options, out.record);
  return out;
}

/// Sigmas of a filter that believes the stated noise are off by a factor of three to ten.
void expect_known_to_err(Method method, std::uint64_t runs) {
  double ratio = 1.0;  // of ANEES, to the power of the runs
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    const Recording recording = with_scales(testing::realistic("drone_none", 10.0, seed), kScales);
    const Flight learned = fly(recording, method), stated = fly(recording, method, false);
    ratio *= learned.summary.anees.value() / stated.summary.anees.value();
    EXPECT_GT(learned.record.imu_noise.value().gyro, 3.0);
    EXPECT_FALSE(stated.record.imu_noise);
    EXPECT_THAT(learned.record.notes, ::testing::Contains(::testing::HasSubstr("errs more than its stated")));
  }
  EXPECT_LT(std::pow(ratio, 1.0 / static_cast<double>(runs)), 0.4);
}

TEST(NoisyImu, OfWhichTheScaleIsOffIsKnownToErr) { expect_known_to_err(Method::kEkf, 1); }

TEST(FullNoisyImu, OfWhichTheScaleIsOffIsKnownToErr) {
  expect_known_to_err(Method::kEkf, 2);
  expect_known_to_err(Method::kLcekf, 2);
  expect_known_to_err(Method::kAdaptive, 2);
}

/// Sigmas of a start that believes the stated noise are off by a factor of three and more.
void expect_known_to_be_noisy(Method method, std::uint64_t seed) {
  const Recording recording = testing::realistic("drone_none", 20.0, seed);
  const Flight noisy = fly(with_noise(recording, 10.0, static_cast<unsigned>(seed)), method);
  EXPECT_LT(noisy.summary.anees.value(), 4.0);
  EXPECT_GT(noisy.record.imu_noise.value().gyro, 4.0);
  EXPECT_GT(noisy.record.imu_noise.value().accel, 3.0);
}

TEST(NoisyImu, IsKnownToBeNoisyFromTheStartOn) { expect_known_to_be_noisy(Method::kEkf, 71); }

TEST(FullNoisyImu, IsKnownToBeNoisyFromTheStartOn) {
  for (const Method method : {Method::kEkf, Method::kLcekf, Method::kAdaptive}) {
    for (const std::uint64_t seed : {71, 72, 73}) {
      expect_known_to_be_noisy(method, seed);
    }
  }
}

class NoisyImuOfAMethod : public ::testing::TestWithParam<Method> {};

TEST_P(NoisyImuOfAMethod, IsNoneWhereTheNoiseIsAsStated) {
  const Recording recording = testing::realistic("drone_none", 10.0, 42);
  const Flight learned = fly(recording, GetParam()), stated = fly(recording, GetParam(), false);
  EXPECT_LT(learned.record.imu_noise.value().gyro, 1.5);
  EXPECT_LT(learned.record.imu_noise.value().accel, 1.5);
  EXPECT_NEAR(learned.summary.anees.value() / stated.summary.anees.value(), 1.0, 0.2);
  EXPECT_NEAR(learned.summary.ate_se3_m.value() / stated.summary.ate_se3_m.value(), 1.0, 0.2);
}

INSTANTIATE_TEST_SUITE_P(Methods, NoisyImuOfAMethod, ::testing::Values(Method::kEkf, Method::kLcekf),
                         [](const auto& info) { return info.param == Method::kEkf ? "ekf" : "lcekf"; });

/// With the truth's start and pixels of a stated noise the filter is the paper's.
TEST(NoisyImu, IsNotLookedForInThePapersExperiment) {
  Scenario scenario = testing::shipped("drone_none", 1.0);
  const Recording recording = simulate(scenario, 3);
  RunOptions options;
  options.start = StartMode::kGroundTruth;
  EXPECT_FALSE(run_recording(recording, options, matched_frames(recording)).imu_noise);
  options.start = StartMode::kAuto;
  EXPECT_TRUE(set_up_run(recording, options).navigator.learn_imu_noise);
}

}  // namespace
}  // namespace limber
