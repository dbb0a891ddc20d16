// SPDX-License-Identifier: MIT
#include "limber/predict/input_checks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "check_covariance.hpp"

namespace limber {
namespace {

using testing::Generator;
using testing::random_normal;

constexpr std::int64_t kMillisecond = 1000000;

/// A small drone: swings and trembles, with the noise of a MEMS IMU at 200 Hz.
std::vector<InputSample> flight(double seconds, std::uint64_t seed = 1) {
  Generator generator(seed);
  std::vector<InputSample> out;
  for (std::int64_t t = 0; t < static_cast<std::int64_t>(seconds * 1e9); t += 5 * kMillisecond) {
    const double s = 1e-9 * static_cast<double>(t);
    const Eigen::Vector3d omega(std::sin(2.0 * s), 0.7 * std::cos(3.0 * s), 0.3);
    const Eigen::Vector3d accel(2.0 * std::cos(3.0 * s), std::sin(300.0 * s), 9.81 + 2.0 * std::sin(s));
    out.push_back(
        {t, omega + 0.005 * random_normal(generator, 3), accel + 0.1 * random_normal(generator, 3)});
  }
  return out;
}

struct Outcome {
  InputFaultCounts faults;
  std::size_t taken = 0;
};

Outcome check(const std::vector<InputSample>& samples) {
  InputChecks checks(kImuLimits);
  InputBuffer buffer;
  for (const InputSample& sample : samples) {
    checks.add(sample, buffer);
  }
  return {checks.take_counts(), buffer.size()};
}

TEST(InputChecks, TakeASoundStreamAsItIs) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const std::vector<InputSample> samples = flight(20.0, seed);
    const Outcome out = check(samples);
    EXPECT_FALSE(out.faults.any());
    EXPECT_EQ(out.taken, samples.size());
  }
}

TEST(InputChecks, LeaveOutASpikeAndNothingElse) {
  for (const double size : {98.1, 981.0}) {
    std::vector<InputSample> samples = flight(5.0);
    samples[500].linear.x() += size;
    const Outcome out = check(samples);
    EXPECT_EQ(out.faults[InputFault::kSpike], 1U);
    EXPECT_EQ(out.taken, samples.size() - 1);
  }
}

/// Noise that is added to the samples of 20 steps about the 500th, none of which may be left out.
std::pair<double, double> densities(const std::vector<InputSample>& samples) {
  InputChecks checks(kImuLimits);
  InputBuffer buffer;
  for (const InputSample& sample : samples) {
    checks.add(sample, buffer);
  }
  EXPECT_FALSE(checks.take_counts().any());
  EXPECT_EQ(buffer.size(), samples.size());
  double angular = 0.0, linear = 0.0;
  for (const InputStep& step : buffer.steps(samples[490].t_ns, samples[510].t_ns)) {
    angular = std::max(angular, step.angular_unknown.density);
    linear = std::max(linear, step.linear_unknown.density);
  }
  return {angular, linear};
}

TEST(InputChecks, TakeAJoltThatLastsWithNoiseOfItsSize) {
  std::vector<InputSample> samples = flight(5.0);
  for (std::size_t k = 500; k < 600; ++k) {
    samples[k].linear.x() += 80.0;
  }
  EXPECT_GE(densities(samples).second, 0.9 * 80.0 * 80.0 * 0.005);
}

/// In one sample 1.5 g throw the velocity by 7 cm/s; it may be the body's.
TEST(InputChecks, TakeASpikeTooSmallToBeLeftOutWithNoiseOfItsSize) {
  std::vector<InputSample> samples = flight(5.0);
  const auto [no_turn, no_jolt] = densities(samples);
  EXPECT_EQ(no_turn, 0.0);
  EXPECT_EQ(no_jolt, 0.0);
  samples[500].linear.y() -= 15.0;
  EXPECT_GE(densities(samples).second, 0.9 * 15.0 * 15.0 * 0.005);
  EXPECT_EQ(densities(samples).first, 0.0);
  samples[500] = flight(5.0)[500];
  samples[500].angular.z() += 0.8;
  EXPECT_GE(densities(samples).first, 0.9 * 0.8 * 0.8 * 0.005);
  EXPECT_EQ(densities(samples).second, 0.0);
}

TEST(InputChecks, TakeAStuckSensorForAGap) {
  std::vector<InputSample> samples = flight(5.0);
  for (std::size_t k = 501; k < 700; ++k) {
    samples[k].angular = samples[500].angular;
    samples[k].linear = samples[500].linear;
  }
  InputChecks checks(kImuLimits);
  InputBuffer buffer;
  for (const InputSample& sample : samples) {
    checks.add(sample, buffer);
  }
  EXPECT_EQ(checks.take_counts()[InputFault::kStuck], 198U);
  EXPECT_NEAR(buffer.longest_gap_s(samples[490].t_ns, samples[710].t_ns), 0.995, 1e-9);
}

TEST(InputChecks, TakeAStreamThatNeverVariedAsItIs) {
  std::vector<InputSample> samples(1000);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    samples[k] = {static_cast<std::int64_t>(k) * 5 * kMillisecond, Eigen::Vector3d::Zero(), {0.0, 0.0, 9.81}};
  }
  const Outcome out = check(samples);
  EXPECT_FALSE(out.faults.any());
  EXPECT_EQ(out.taken, samples.size());
}

TEST(InputChecks, TakeSamplesThatADriverHandsOutTwice) {
  std::vector<InputSample> samples = flight(5.0);
  for (std::size_t k = 1; k < samples.size(); k += 2) {
    samples[k].angular = samples[k - 1].angular;
    samples[k].linear = samples[k - 1].linear;
  }
  EXPECT_FALSE(check(samples).faults.any());
}

/// Wheels that drive, stop, and drive on: their encoders count whole steps, and none at rest.
std::vector<InputSample> wheels(double step) {
  std::vector<InputSample> samples(1500);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const double t = 0.02 * static_cast<double>(k);
    const double v = k > 500 && k < 1000 ? 0.0 : 0.8 + 0.3 * std::sin(t);
    const double turn = k > 500 && k < 1000 ? 0.0 : 0.2 * std::sin(0.3 * t);
    const auto counted = [step](double x) { return step > 0.0 ? step * std::round(x / step) : x; };
    samples[k] = {
        static_cast<std::int64_t>(k) * 20 * kMillisecond, {0.0, 0.0, counted(turn)}, {counted(v), 0.0, 0.0}};
  }
  return samples;
}

TEST(InputChecks, TakeWheelsThatStandStillOrCountSteps) {
  for (const double step : {0.0, 0.02}) {
    InputChecks checks(kOdometryLimits);
    InputBuffer buffer;
    for (const InputSample& sample : wheels(step)) checks.add(sample, buffer);
    EXPECT_FALSE(checks.take_counts().any()) << step;
  }
}

TEST(InputChecks, TakeWheelsThatRepeatThemselvesWhereTheyNeverDidForStuck) {
  std::vector<InputSample> samples = wheels(0.0);
  for (std::size_t k = 301; k < 400; ++k) {
    samples[k].angular = samples[300].angular;
    samples[k].linear = samples[300].linear;
  }
  for (std::size_t k = 1201; k < 1300; ++k) {  // and once more
    samples[k].angular = samples[1200].angular;
    samples[k].linear = samples[1200].linear;
  }
  InputChecks checks(kOdometryLimits);
  InputBuffer buffer;
  for (const InputSample& sample : samples) checks.add(sample, buffer);
  EXPECT_EQ(checks.take_counts()[InputFault::kStuck], 2U * 98U);
}

/// What a driver takes off as a bias comes off the ends of the range, too: they differ by axis and direction.
TEST(InputChecks, KnowTheEndsOfARangeThatAnOffsetHasMoved) {
  std::vector<InputSample> samples = flight(20.0);
  for (InputSample& sample : samples) {
    sample.angular = sample.angular.cwiseMax(-0.7).cwiseMin(0.7) - Eigen::Vector3d(0.01, -0.02, 0.005);
  }
  EXPECT_GE(check(samples).faults[InputFault::kSaturated], samples.size() / 10);
}

TEST(InputChecks, GiveASaturatedGyroscopeMoreNoise) {
  std::vector<InputSample> samples = flight(20.0);
  for (InputSample& sample : samples) {
    sample.angular = sample.angular.cwiseMax(-0.7).cwiseMin(0.7);
  }
  InputChecks checks(kImuLimits);
  InputBuffer buffer;
  for (const InputSample& sample : samples) {
    checks.add(sample, buffer);
  }
  EXPECT_GE(checks.take_counts()[InputFault::kSaturated], samples.size() / 10);
  double density = 0.0;
  for (const InputStep& step : buffer.steps(0, samples.back().t_ns)) {
    density = std::max(density, step.angular_unknown.density);
  }
  EXPECT_GE(density, 1e-3 * 0.07 * 0.07);
}

TEST(InputChecks, LeaveOutWhatNoSensorCanShow) {
  std::vector<InputSample> samples = flight(5.0);
  samples[300].angular.y() = 1e300;
  samples[700].linear.z() = -1e300;
  const Outcome out = check(samples);
  EXPECT_EQ(out.faults[InputFault::kImpossible], 2U);
  EXPECT_EQ(out.taken, samples.size() - 2);
}

TEST(InputChecks, RefuseWhatIsNotFiniteOrOutOfOrder) {
  InputChecks checks(kImuLimits);
  InputBuffer buffer;
  checks.add({10, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()}, buffer);
  EXPECT_THROW(checks.add({10, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()}, buffer),
               std::invalid_argument);
  EXPECT_THROW(checks.add({5, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()}, buffer),
               std::invalid_argument);
  const Eigen::Vector3d nan = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_THROW(checks.add({20, nan, Eigen::Vector3d::Zero()}, buffer), std::invalid_argument);
  EXPECT_NO_THROW(checks.add({20, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()}, buffer));
}

}  // namespace
}  // namespace limber
