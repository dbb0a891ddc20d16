// SPDX-License-Identifier: MIT
// Runs that begin at rest, longer than a start had once waited.
#include <gtest/gtest.h>

#include <cmath>
#include <variant>

#include "limber/diagnose/run_summary.hpp"
#include "limber/simulate/scenario_presets.hpp"
#include "limber/simulate/simulator.hpp"
#include "recorded_run.hpp"
#include "shipped_scenario.hpp"

namespace limber {
namespace {

constexpr double kRest = 12.0;  // [s]

/// A drone that takes off slowly, with realistic pixels.
Recording drone_at_rest(std::uint64_t seed) {
  Scenario scenario = testing::shipped("drone_moving", {}, PixelPreset::kRealistic);
  scenario.stereo_rate = 10.0;
  std::get<RandomSplineTrajectory>(scenario.trajectory).rest = kRest;
  scenario.duration = kRest + 14.0;
  return simulate(scenario, seed);
}

/// A filter that had taken over a scale that nobody knew, after 8 s at rest, was sure of a wrong one: 0.3 to
/// 2.5 m off, ANEES of the scale 28 to 66, exit code 0.
TEST(StartAtRest, WaitsForTheMotionThatTellsTheScale) {
  const Recording recording = drone_at_rest(4);
  RunOptions options;
  const RunRecord record = testing::run(recording, options);
  EXPECT_GT(record.sensor_start->waited_s, kRest);
  EXPECT_LT(record.sensor_start->scale_sigma, 0.2);
  ASSERT_EQ(record.trajectory.size(), recording.frames.size());
  double before = 0.0;  // variance: where the window begins anew is known no better than what led there
  for (const TrajectoryRow& row : record.trajectory) {
    const double variance = row.covariance->topLeftCorner<3, 3>().trace();
    EXPECT_GT(variance, 0.5 * before) << row.t_ns;
    before = variance;
    if (1e-9 * static_cast<double>(row.t_ns - record.trajectory.front().t_ns) < kRest) {
      EXPECT_LT((row.T_world_body.p - record.trajectory.front().T_world_body.p).norm(), 0.02) << row.t_ns;
    }
  }
  const RunSummary found = summarize(recording, options, record);
  EXPECT_LT(found.ate_se3_m.value(), 0.15);
  EXPECT_LT(found.anees_scale.value(), 6.0);
  EXPECT_LT(found.anees.value(), 4.0);
}

/// A robot that creeps, its accelerometer as noisy as what it gains in half a second.
Recording creeping(std::uint64_t seed) {
  Scenario scenario = testing::shipped("creeping", 15.0);
  scenario.stereo_rate = 10.0;
  scenario.world.points = 120;
  std::get<RandomSplineTrajectory>(scenario.trajectory).max_speed = 0.3;
  return simulate(scenario, seed);
}

/// Nothing had told the scale, and the start's map had shrunk until its points were nearer than a baseline:
/// all were dropped, the start was given up, and its filter was 6 cm off, ANEES 17.
TEST(StartAtRest, OfABodyThatCreepsKeepsAMapThatIsSmall) {
  const Recording recording = creeping(11);
  RunOptions options;
  options.method = Method::kLcekf;
  const RunRecord record = testing::run(recording, options);
  const RunSummary found = summarize(recording, options, record);
  EXPECT_LT(found.ate_se3_m.value(), 0.02);
  EXPECT_LT(found.anees.value(), 2.0);
}

/// A drone that nobody flies, with realistic pixels.
Recording drone_on_the_ground(double half_extent, double duration) {
  Scenario scenario = testing::shipped("drone_none", {}, PixelPreset::kRealistic);
  RandomSplineTrajectory motion;
  motion.half_extent = Eigen::Vector3d(half_extent, half_extent, half_extent / 3.0);
  motion.max_speed = 0.03;
  motion.max_angular_rate = 0.05;
  motion.rest = half_extent > 0.0 ? 0.0 : duration;
  scenario.trajectory = motion;
  scenario.stereo_rate = 10.0;
  scenario.duration = duration;
  return simulate(scenario, 12);
}

/// The start had taken over a scale that was anyone's, and the doubt that came of it had learned a baseline
/// that is shorter than nothing: tx -167 +- 19 mm of 120.
TEST(StartAtRest, AdaptiveLearnsNoLengthThatNobodyKnows) {
  const Recording recording = drone_on_the_ground(0.0, 8.0);
  RunOptions options;
  options.method = Method::kAdaptive;
  const RunRecord record = testing::run(recording, options);
  const CalibrationEstimate& last = record.calibration.back().estimate;
  constexpr Eigen::Index kTx = 3;
  EXPECT_LT(std::abs(last.error(kTx)), 1e-3);
  EXPECT_LT(std::abs(last.error(kTx)), 3.0 * last.sigma(kTx));
  EXPECT_EQ(told_parameters(last)[kTx], !last.trusts_rig);
}

/// Where it creeps, frames that a waiting start drops had a scale that was anyone's: 61 and 57 mm off.
void expect_scale_of_the_rig(Method method, double largest_rmse) {
  const Recording recording = drone_on_the_ground(0.3, 10.0);
  RunOptions options;
  options.method = method;
  const RunRecord record = testing::run(recording, options);
  const RunSummary found = summarize(recording, options, record);
  EXPECT_LT(found.position_rmse_m.value(), largest_rmse);
  EXPECT_LT(found.anees.value(), 2.0);
  if (method == Method::kLcekf) {
    EXPECT_GT(record.sensor_start->scale_sigma, 1.0);  // but it is not taken for known
    EXPECT_FALSE(record.start.scale_told);
  }
}

TEST(StartAtRest, ScaleThatNobodyKnowsIsTheRigs) { expect_scale_of_the_rig(Method::kLcekf, 0.04); }

TEST(FullStartAtRest, ScaleThatNobodyKnowsIsTheRigs) { expect_scale_of_the_rig(Method::kAdaptive, 0.02); }

}  // namespace
}  // namespace limber
