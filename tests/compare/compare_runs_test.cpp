// SPDX-License-Identifier: MIT
#include "limber/compare/compare_runs.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "compare/run_files_of.hpp"
#include "datasets/files.hpp"
#include "limber/core/errors.hpp"
#include "limber/core/so3.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;
using testing::data_error_of;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::RunFilesOf;
using testing::TemporaryFolder;

/// Runs of made-up errors: files as limber run writes them, of a walk of 120 m in 60 s.
class CompareRuns : public ::testing::Test {
 protected:
  [[nodiscard]] fs::path folder() const { return folder_.path(); }
  [[nodiscard]] fs::path write(const std::string& name, RunFilesOf run) const {
    run.write(folder() / name);
    return folder() / name;
  }
  [[nodiscard]] static RunComparison compare(const std::vector<fs::path>& folders,
                                             const CompareOptions& options = {}) {
    return compare_runs(folders, options);
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(CompareRuns, SayWhatTheErrorIsWhereItIsKnownOnPaper) {
  RunFilesOf run("ekf");
  run.scale = 1.02;  // of the estimate: 2 cm off after each metre
  const RunComparison comparison = compare({write("a", run)});
  ASSERT_EQ(comparison.runs.size(), 1U);
  const ComparedRun& a = comparison.runs[0];
  EXPECT_EQ(a.label, "ekf");
  EXPECT_EQ(a.recording, "walk");
  EXPECT_EQ(a.end, RunEnd::kDone);
  EXPECT_NEAR(a.scale_error_percent.value(), 2.0, 1e-6);
  EXPECT_EQ(a.piece_m, 10.0);
  EXPECT_EQ(a.pieces, 12U);
  // A piece is 10 m along the path and a little less from end to end.
  EXPECT_NEAR(a.rpe_percent.value(), 2.0, 0.1);
  EXPECT_LT(a.rpe_percent.value(), 2.05);
  EXPECT_NEAR(a.rpe_deg.value(), 0.0, 1e-6);
  EXPECT_NEAR(a.attitude_rmse_deg.value(), 0.0, 1e-6);
  EXPECT_EQ(a.anees, 1.5);
  EXPECT_EQ(a.verdict, "degraded");
  EXPECT_EQ(a.ms_per_frame, 2.0);
  EXPECT_THAT(comparison.differences, IsEmpty());
}

TEST_F(CompareRuns, ADifferenceThatIsThereIsSeen) {
  RunFilesOf good("ekf"), bad("lcekf");
  good.scale = 1.01;
  bad.scale = 1.04;
  const RunComparison comparison = compare({write("a", good), write("b", bad)});
  ASSERT_EQ(comparison.differences.size(), 1U);
  const RunDifference& difference = comparison.differences[0];
  EXPECT_EQ(difference.run, 1U);
  EXPECT_EQ(difference.against, 0U);
  ASSERT_TRUE(difference.rpe_percent && difference.rpe_percent->lower);
  EXPECT_NEAR(difference.rpe_percent->mean, 3.0, 0.1);
  EXPECT_EQ(judge(*difference.rpe_percent), Judgement::kWorse);
  EXPECT_GT(difference.ate_m.value(), 0.1);
  const RunComparison other_way = compare({folder() / "b", folder() / "a"});
  EXPECT_EQ(judge(*other_way.differences[0].rpe_percent), Judgement::kBetter);
}

TEST_F(CompareRuns, NothingIsSeenWhereThereIsNoDifference) {
  // Both drift alike, by chance in every piece anew. Binomial(16, 0.05) leaves more than four false alarms a
  // probability of 0.1 %.
  std::size_t false_alarms = 0;
  for (std::uint64_t seed = 0; seed < 16; ++seed) {
    RunFilesOf a("ekf"), b("lcekf");
    a.drift = b.drift = 0.02;
    a.seconds = b.seconds = 24.0;
    a.seed = 2 * seed + 1;
    b.seed = 2 * seed + 2;
    const RunComparison comparison = compare({write("a", a), write("b", b)});
    false_alarms += judge(*comparison.differences[0].rpe_percent) == Judgement::kCannotTell ? 0 : 1;
  }
  EXPECT_LE(false_alarms, 4U);
}

TEST_F(CompareRuns, TooShortARunSaysThatItCannotTell) {
  RunFilesOf a("ekf"), b("lcekf");
  a.seconds = b.seconds = 3.0;
  b.scale = 1.5;
  const RunComparison comparison = compare({write("a", a), write("b", b)});
  ASSERT_TRUE(comparison.differences[0].rpe_percent);
  EXPECT_FALSE(comparison.differences[0].rpe_percent->lower);
  EXPECT_EQ(judge(*comparison.differences[0].rpe_percent), Judgement::kCannotTell);
  EXPECT_THAT(difference_in_words(*comparison.differences[0].rpe_percent), HasSubstr("too few pieces"));
}

TEST_F(CompareRuns, WithoutTruthSayHowFarTheyAreApart) {
  RunFilesOf a("ekf"), b("lcekf");
  a.has_truth = b.has_truth = false;
  b.scale = 1.1;
  b.yaw = 0.7;  // its world is turned: what starts put together takes away
  const RunComparison comparison = compare({write("a", a), write("b", b)});
  EXPECT_FALSE(comparison.runs[0].has_truth || comparison.runs[0].ate_m || comparison.runs[0].rpe_percent);
  EXPECT_NEAR(comparison.runs[0].path_length_m, 120.0, 1.0);
  const RunDifference& difference = comparison.differences[0];
  EXPECT_FALSE(difference.rpe_percent || difference.ate_m);
  const Eigen::Vector3d end = RunFilesOf::position(60.0) - RunFilesOf::position(0.0);
  EXPECT_NEAR(difference.apart_end_m, 0.1 * end.norm(), 1e-6);
  EXPECT_NEAR(difference.apart_end_deg, 0.0, 1e-6);
  EXPECT_GT(difference.apart_rms_m, 0.0);
}

TEST_F(CompareRuns, OtherRecordingsAreNotPaired) {
  RunFilesOf a("ekf"), other("lcekf"), moved("adaptive"), later("soft"), again("consider");
  other.recording = "elsewhere";
  moved.bend = 0.3;  // the same name and stamps, but another motion
  later.begin_ns += 7'000'000;
  const RunComparison comparison =
      compare({write("a", a), write("b", other), write("c", moved), write("d", later), write("e", again)});
  ASSERT_EQ(comparison.differences.size(), 1U);
  EXPECT_EQ(comparison.differences[0].run, 4U);
  EXPECT_THAT(comparison.notes, ElementsAre(HasSubstr("lcekf is of another recording (elsewhere)"),
                                            HasSubstr("adaptive is of another recording (walk)"),
                                            HasSubstr("soft is of another")));
}

TEST_F(CompareRuns, OtherAssumptionsAreNotPairedUnlessAskedFor) {
  RunFilesOf a("ekf"), noisier("lcekf"), bent("adaptive"), blind("soft"), constrained("consider");
  noisier.sigma_px = 0.7;
  bent.theta_assumed = {0.0, 0.01, 0.0, -0.1, 0.0, 0.0};
  blind.observed = 31;
  constrained.constraints = "rotation";  // what a method does with it
  const std::vector<fs::path> folders = {write("a", a), write("b", noisier), write("c", bent),
                                         write("d", blind), write("e", constrained)};
  const RunComparison comparison = compare(folders);
  ASSERT_EQ(comparison.differences.size(), 4U);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_FALSE(comparison.differences[k].rpe_percent || comparison.differences[k].ate_m) << k;
  }
  EXPECT_THAT(comparison.differences[0].assumptions, ElementsAre("sigma_px (by default, 0.7)"));
  EXPECT_THAT(comparison.differences[1].assumptions, ElementsAre("the calibration"));
  EXPECT_THAT(comparison.differences[2].assumptions, ElementsAre(HasSubstr("the points seen")));
  EXPECT_TRUE(comparison.differences[3].rpe_percent);
  EXPECT_THAT(comparison.notes[0], HasSubstr("their errors are not paired"));
  const RunComparison across = compare(folders, {{}, true});
  EXPECT_TRUE(across.differences[0].rpe_percent && across.differences[0].ate_m);
  EXPECT_THAT(across.notes[0], HasSubstr("method and assumptions"));
}

TEST_F(CompareRuns, APartialRunIsComparedOverWhatItHas) {
  RunFilesOf whole("ekf"), partial("lcekf"), lost("soft");
  whole.scale = 1.01;
  partial.seconds = 31.0;
  partial.frames_of_recording = lost.frames_of_recording = 601;
  partial.complete = false;
  partial.scale = 1.02;
  lost.lost_after_s = 12.5;
  const RunComparison comparison = compare({write("a", whole), write("b", partial), write("c", lost)});
  EXPECT_EQ(comparison.runs[1].end, RunEnd::kPartial);
  EXPECT_EQ(comparison.runs[1].frames_of_recording, 601U);
  EXPECT_EQ(comparison.runs[2].end, RunEnd::kLost);
  EXPECT_NEAR(comparison.runs[2].lost_since_s.value(), 12.5, 1e-5);
  EXPECT_EQ(comparison.differences[0].frames, 311U);
  EXPECT_EQ(comparison.differences[0].rpe_percent->count, 6U);
  EXPECT_NEAR(comparison.differences[0].rpe_percent->mean, 1.0, 0.05);
}

TEST_F(CompareRuns, ATruthThatIsNotLevelHidesNothing) {
  RunFilesOf a("ekf"), b("lcekf");
  a.scale = b.scale = 1.001;
  a.truth_roll = 1.2;  // truth.tum joins the estimate at the first pose, and leans away from there
  const RunComparison comparison = compare({write("a", a), write("b", b)});
  EXPECT_TRUE(comparison.runs[0].truth_is_tilted);
  EXPECT_LT(comparison.runs[0].anees.value(), 1.0);  // of the files, made 1.5 by another version
  EXPECT_LT(comparison.runs[0].ate_m.value(), 0.1);
  EXPECT_LT(comparison.runs[0].attitude_rmse_deg.value(), 1e-6);
  EXPECT_FALSE(comparison.runs[1].truth_is_tilted);
  EXPECT_EQ(comparison.runs[1].anees, 1.5);
  EXPECT_THAT(comparison.notes, ElementsAre(HasSubstr("ekf: the world of the truth is not level")));
  EXPECT_NEAR(comparison.differences[0].ate_m.value(), 0.0, 1e-6);
}

TEST_F(CompareRuns, RunsOfOneMethodHaveTheNamesOfTheirFolders) {
  const RunFilesOf run("ekf");
  const RunComparison comparison = compare({write("monday/a", run), write("tuesday/a", run)});
  EXPECT_EQ(comparison.runs[0].label, "monday/a");
  EXPECT_EQ(comparison.runs[1].label, "tuesday/a");
  // Nothing is different: the interval is the point zero.
  EXPECT_EQ(comparison.differences[0].rpe_percent->lower, 0.0);
  EXPECT_EQ(judge(*comparison.differences[0].rpe_percent), Judgement::kCannotTell);
  EXPECT_THROW((void)compare({folder() / "monday/a", folder() / "monday" / "." / "a" / ""}),
               std::invalid_argument);
}

TEST_F(CompareRuns, AFolderOfRunsStandsForThem) {
  const fs::path b = write("all/b", RunFilesOf("lcekf")), a = write("all/a", RunFilesOf("ekf"));
  fs::create_directories(folder() / "all/notes");
  EXPECT_THAT(run_folders(std::vector{folder() / "all"}), ElementsAre(a, b));
  EXPECT_THAT(run_folders(std::vector{b}), ElementsAre(b));
  for (const fs::path& bad : {folder() / "none", folder() / "all/notes", a / "summary.json"}) {
    const DataError error = data_error_of([&] { (void)run_folders(std::vector{bad}); });
    EXPECT_EQ(error.file(), bad.string());
    EXPECT_THAT(error.what(), HasSubstr("expected the folder of a run"));
  }
}

TEST_F(CompareRuns, NamesTheFileThatIsBroken) {
  const fs::path a = write("a", RunFilesOf("ekf"));
  testing::write_text(a / "trajectory.csv", "1,2,3\n");
  EXPECT_EQ(data_error_of([&] { (void)compare({a}); }).file(), (a / "trajectory.csv").string());
  EXPECT_THROW((void)compare({}), std::invalid_argument);
}

}  // namespace
}  // namespace limber
