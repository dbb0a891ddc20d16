// SPDX-License-Identifier: MIT
// Rows that are exposed one after the other: noticed where they are, and not where the rig bends.
#include "limber/diagnose/readout_watch.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "limber/datasets/read_recording.hpp"
#include "limber/diagnose/run_summary.hpp"
#include "limber/simulate/scenario_presets.hpp"
#include "real_data.hpp"
#include "rolling_rows.hpp"
#include "shipped_scenario.hpp"

namespace limber {
namespace {

using ::testing::HasSubstr;

Scenario turning_drone(const std::string& name, double seconds) {
  Scenario scenario = testing::shipped(name, seconds);
  scenario.noise.pixel = 0.15;  // as a tracker has it
  return scenario;
}

std::optional<ReadoutTime> watched(const Recording& recording) {
  ReadoutWatch watch(recording.calibration);
  for (const StereoFrame& frame : recording.frames) {
    watch.add(frame);
  }
  return watch.estimate();
}

/// Drones that turn, with a sound rig and one that swings.
TEST(ReadoutWatch, FindsHowLongTheRowsTakeWhateverTheRigDoes) {
  for (const char* name : {"drone_none", "drone_sinus"}) {
    for (const double readout : {0.0, 0.02}) {
      const Recording recording = testing::with_rolling_rows(turning_drone(name, 16.0), readout, 3);
      const auto found = watched(recording);
      ASSERT_TRUE(found);
      EXPECT_NEAR(found->seconds, readout, 5.0 * found->sigma) << name;
      EXPECT_LT(found->sigma, 0.002) << name;
      EXPECT_EQ(contradicts(*found, recording.calibration), readout != 0.0) << name;
    }
  }
}

/// The spread of the estimates says whether their sigmas are right.
TEST(ReadoutWatch, SaysNothingOfRowsThatAreExposedAtOnceWithRealisticPixels) {
  double normalized_squared = 0.0;
  constexpr int kRuns = 8;
  for (int seed = 51; seed < 51 + kRuns; ++seed) {
    Scenario scenario = turning_drone("drone_none", 14.0);
    set_pixels(scenario, PixelPreset::kRealistic);
    const Recording recording = simulate(scenario, static_cast<std::uint64_t>(seed));
    const auto found = watched(recording);
    ASSERT_TRUE(found);
    EXPECT_FALSE(contradicts(*found, recording.calibration));
    normalized_squared += std::pow(found->seconds / found->sigma, 2) / kRuns;
  }
  EXPECT_LT(normalized_squared, 4.0);  // fourteen seconds tell their own spread within a factor of two
}

TEST(ReadoutWatch, ComparesWithWhatTheCalibrationSays) {
  Recording recording = testing::with_rolling_rows(turning_drone("drone_none", 16.0), 0.02, 4);
  recording.calibration.readout_time_s = {0.02, 0.02};
  EXPECT_FALSE(contradicts(watched(recording).value(), recording.calibration));
  recording.calibration.readout_time_s = {-0.02, -0.02};
  const ReadoutTime found = watched(recording).value();
  EXPECT_TRUE(contradicts(found, recording.calibration));
  EXPECT_THAT(in_words(found, recording.calibration), HasSubstr("-20 ms were assumed: --readout-time 0.0"));
}

TEST(ReadoutWatch, IsSilentOnFewSeconds) {
  EXPECT_FALSE(watched(testing::with_rolling_rows(turning_drone("drone_none", 5.0), 0.02, 3)));
}

TEST(ReadoutWatch, SaysNothingOfRealRecordings) {
  LIMBER_NEED_DATA(folder, "track_logs");
  for (const char* name : {"euroc_imu_april", "kitti_09_26_drive_0036", "kitti_09_30_drive_0027"}) {
    const Recording recording = read_recording(folder / name);
    const auto found = watched(recording);
    EXPECT_FALSE(found && contradicts(*found, recording.calibration)) << name;
  }
}

TEST(ReadoutWatch, ThatContradictsTheCalibrationIsSaidFirstAndLeavesTheRigUnjudged) {
  RunRecord record;
  record.notes = {"another"};
  RunSummary summary;
  summary.health.emplace();
  summary.health->verdict = HealthVerdict::kDecalibrated;
  const StereoCalibration global;
  add_readout(ReadoutTime{0.02, 0.001, 0.01}, global, record, summary);
  EXPECT_EQ(summary.health->verdict, HealthVerdict::kDecalibrated) << "it explains nothing";
  EXPECT_FALSE(summary.readout_contradicted);
  add_readout(ReadoutTime{0.02, 0.001, 0.5}, global, record, summary);
  EXPECT_EQ(summary.health->verdict, HealthVerdict::kCannotTell);
  EXPECT_TRUE(summary.readout_contradicted);
  EXPECT_THAT(record.notes.front(), HasSubstr("rolling shutter"));
  EXPECT_EQ(record.notes.size(), 2U);
}

}  // namespace
}  // namespace limber
