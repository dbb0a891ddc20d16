// SPDX-License-Identifier: MIT
// Runs that begin at rest, longer than a start had once waited.
#include <gtest/gtest.h>

#include <variant>

#include "limber/diagnose/run_summary.hpp"
#include "limber/simulate/scenario_file.hpp"
#include "limber/simulate/scenario_presets.hpp"
#include "limber/simulate/simulator.hpp"
#include "recorded_run.hpp"
#include "source_folder.hpp"

namespace limber {
namespace {

constexpr double kRest = 12.0;  // [s]

/// A drone that takes off slowly, with realistic pixels.
Recording drone_at_rest(std::uint64_t seed) {
  Scenario scenario = read_scenario(testing::source_folder() / "scenarios" / "drone_moving.yaml");
  set_pixels(scenario, PixelPreset::kRealistic);
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

}  // namespace
}  // namespace limber
