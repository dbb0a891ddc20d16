// SPDX-License-Identifier: MIT
#include "limber/run_files/run_results.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "datasets/files.hpp"
#include "limber/run_files/run_output.hpp"
#include "run/short_recording.hpp"

namespace limber {
namespace {

using Level = Diagnostic::Level;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Pair;
using ::testing::StartsWith;

TEST(CalibrationDiagnostic, HasTheVerdictsLevel) {
  HealthRow row;
  const auto level_of = [&row](HealthVerdict verdict) {
    row.verdict = verdict;
    const Diagnostic diagnostic = calibration_diagnostic(row);
    EXPECT_THAT(diagnostic.message, StartsWith(to_string(verdict)));
    return diagnostic.level;
  };
  EXPECT_EQ(level_of(HealthVerdict::kOk), Level::kOk);
  EXPECT_EQ(level_of(HealthVerdict::kDegraded), Level::kWarning);
  EXPECT_EQ(level_of(HealthVerdict::kDecalibrated), Level::kError);
  EXPECT_EQ(level_of(HealthVerdict::kCannotTell), Level::kStale);
}

TEST(CalibrationDiagnostic, SaysSizesInTheUnitsOfHealthCsv) {
  HealthRow row;
  row.t_ns = 7;
  row.epipolar_px = {0.25, 0.125, 0.5};
  row.depth = {0.02, 0.01, 0.04};
  row.delta << 0, M_PI / 360.0, 0, 0, 0, 0.003;
  row.sigma = 0.5 * row.delta;
  row.axes[1] = HealthVerdict::kDecalibrated;
  const Diagnostic diagnostic = calibration_diagnostic(row);
  EXPECT_EQ(diagnostic.t_ns, 7);
  EXPECT_THAT(diagnostic.message,
              HasSubstr("0.25 px off the epipolar lines (0.12 to 0.5), 2 % of depth (1 to 4)"));
  EXPECT_THAT(diagnostic.values, Contains(Pair("epipolar [px] high", "0.5")));
  EXPECT_THAT(diagnostic.values, Contains(Pair("depth [%] low", "1")));
  EXPECT_THAT(diagnostic.values, Contains(Pair("ay [deg]", "0.5")));
  EXPECT_THAT(diagnostic.values, Contains(Pair("ay sigma [deg]", "0.25")));
  EXPECT_THAT(diagnostic.values, Contains(Pair("ay verdict", "decalibrated")));
  EXPECT_THAT(diagnostic.values, Contains(Pair("tz [mm]", "3")));
}

TEST(NavigationDiagnostic, WarnsOfWhatTheFrameOrItsInputsLackAndCallsALostFilterLost) {
  FrameRow row;
  row.status = UpdateStatus::kUpdated;
  row.inputs = InputStatus::kSound;
  row.used = 12;
  EXPECT_EQ(navigation_diagnostic(row, false).level, Level::kOk);
  EXPECT_THAT(navigation_diagnostic(row, false).values, Contains(Pair("points used", "12")));
  EXPECT_EQ(navigation_diagnostic(row, true).level, Level::kError);
  row.inputs = InputStatus::kGap;
  EXPECT_EQ(navigation_diagnostic(row, false).level, Level::kWarning);
  EXPECT_EQ(navigation_diagnostic(row, false).message, "inputs: gap");
  row.status = UpdateStatus::kEmpty;
  EXPECT_THAT(navigation_diagnostic(row, false).message, HasSubstr("no points"));
}

TEST(RunResults, AreWhatTheFilesOfARunSay) {
  const testing::TemporaryFolder folder;
  const Recording recording = testing::short_recording();
  RunOptions options;
  options.start = StartMode::kGroundTruth;
  RunRecord record = run_recording(recording, options, matched_frames(recording));
  record.frames[20].reset = true;
  write_run_output(folder.path(), options, record, summarize(recording, options, record));
  EXPECT_TRUE(is_run_folder(folder.path()));
  const RunResults results = read_run_results(folder.path());
  EXPECT_EQ(results.trajectory.size(), record.frames.size());
  EXPECT_EQ(results.truth.size(), record.frames.size());
  EXPECT_FALSE(results.landmarks.empty());
  std::size_t frames = 0;
  for (const Diagnostic& diagnostic : results.diagnostics) {
    if (diagnostic.name == "limber: navigation") {
      EXPECT_EQ(diagnostic.level == Level::kError, frames >= 20) << frames << ": lost from then on";
      ++frames;
    }
  }
  EXPECT_EQ(frames, record.frames.size());
  RunSummary summary = summarize(recording, options, record);
  summary.inputs.lost_since_ns = record.frames[10].t_ns;  // what was found out afterwards
  write_run_output(folder.path(), options, record, summary);
  const auto errors = std::ranges::count_if(
      read_run_results(folder.path()).diagnostics,
      [](const Diagnostic& d) { return d.name == "limber: navigation" && d.level == Level::kError; });
  EXPECT_EQ(errors, static_cast<std::ptrdiff_t>(record.frames.size() - 10));
  std::filesystem::remove(folder.path() / "frames.csv");
  EXPECT_EQ(testing::data_error_of([&] { (void)read_run_results(folder.path()); }).file(),
            (folder.path() / "frames.csv").string());
}

}  // namespace
}  // namespace limber
