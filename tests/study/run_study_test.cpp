// SPDX-License-Identifier: MIT
#include "limber/study/run_study.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "datasets/files.hpp"
#include "limber/study/study_database.hpp"
#include "study/tiny_study.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;

using testing::content_of;
using ::testing::HasSubstr;
using testing::kHopeless;
using testing::rows_of;
using testing::TemporaryFolder;
using testing::tiny_plan;
using testing::tiny_scenario;
using testing::two_cases;

StudyOptions with_threads(int threads) {
  StudyOptions options;
  options.threads = threads;
  return options;
}

std::string message_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  ADD_FAILURE() << "no error";
  return "";
}

/// What one thread makes of two_cases(runs).
std::vector<std::string> reference(std::uint64_t runs) {
  const TemporaryFolder folder;
  run_study(two_cases(runs), folder.path() / "s.sqlite", with_threads(1));
  return content_of(folder.path() / "s.sqlite");
}

TEST(RunStudy, FillsADatabaseWithEveryRunOfEveryMethod) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "s.sqlite";
  const StudyOutcome outcome = run_study(two_cases(5), path, with_threads(2));
  EXPECT_FALSE(outcome.stopped);
  EXPECT_EQ(outcome.progress.total, 4u * 5u + 2u * 3u);
  EXPECT_EQ(outcome.progress.runs, outcome.progress.total);
  EXPECT_EQ(outcome.progress.now, outcome.progress.total);
  EXPECT_EQ(rows_of(path, "SELECT case_id, method, count(*), min(run), max(run) FROM runs GROUP BY 1, 2"),
            (std::vector<std::string>{"1|0|5|0|4", "1|1|5|0|4", "1|2|5|0|4", "1|3|5|0|4", "2|0|3|0|2",
                                      "2|1|3|0|2"}));
  EXPECT_EQ(testing::files_in(folder.path()), std::vector<std::string>{"s.sqlite"});
}

TEST(RunStudy, GivesTheSameBitsWithAnyNumberOfThreads) {
  const std::vector<std::string> one = reference(6);
  for (const int threads : {2, 5}) {
    const TemporaryFolder folder;
    run_study(two_cases(6), folder.path() / "s.sqlite", with_threads(threads));
    EXPECT_EQ(content_of(folder.path() / "s.sqlite"), one) << threads;
  }
}

TEST(RunStudy, GoesOnAfterAStopAndEndsWithTheSameBits) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "s.sqlite";
  std::uint64_t stopped_with = 0;
  StudyOptions options = with_threads(2);
  options.progress = [&](const StudyProgress& progress) { stopped_with = progress.now; };
  options.stop = [&] { return stopped_with >= 8; };
  const StudyOutcome first = run_study(two_cases(6), path, options);
  EXPECT_TRUE(first.stopped);
  EXPECT_LT(first.progress.runs, first.progress.total);
  const StudyOutcome second = run_study(two_cases(6), path, with_threads(1));
  EXPECT_FALSE(second.stopped);
  EXPECT_EQ(second.progress.now, second.progress.total - first.progress.runs);
  EXPECT_EQ(content_of(path), reference(6));
}

TEST(RunStudy, DoesNothingWhereNothingIsLeftToDo) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "s.sqlite";
  run_study(two_cases(2), path);
  const StudyOutcome again = run_study(two_cases(2), path);
  EXPECT_EQ(again.progress.now, 0u);
  EXPECT_EQ(again.progress.runs, again.progress.total);
  EXPECT_EQ(content_of(path), reference(2));
}

TEST(RunStudy, AddsRunsAndCasesLaterAndEndsWithTheSameBits) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "s.sqlite";
  StudyPlan few = two_cases(6);
  few.cases.pop_back();
  few.cases[0].runs = 2;
  run_study(few, path);
  run_study(two_cases(6), path);
  EXPECT_EQ(content_of(path), reference(6));
  run_study(few, path);  // asks for less than there is
  EXPECT_EQ(content_of(path), reference(6));
}

TEST(RunStudy, RefusesToMixAnotherSeedScenarioOrMethodIn) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "s.sqlite";
  run_study(tiny_plan(2), path);
  const std::vector<std::string> before = content_of(path);

  StudyPlan other = tiny_plan(2);
  other.seed = 2;
  EXPECT_THAT(message_of([&] { run_study(other, path); }), HasSubstr("was begun with seed 1, not 2"));
  other = tiny_plan(2);
  other.cases[0].scenario.noise.pixel = 0.6;
  const std::string message = message_of([&] { run_study(other, path); });
  EXPECT_THAT(message, HasSubstr("holds 'tiny' with other settings than these"));
  EXPECT_THAT(message, HasSubstr("stored:   pixel: 0.5  # px"));
  EXPECT_THAT(message, HasSubstr("now:      pixel: 0.6  # px"));
  EXPECT_THAT(message_of([&] { run_study(tiny_plan(2, "ekf,lcekf"), path); }),
              HasSubstr("stored:   - ekf-full"));
  EXPECT_EQ(content_of(path), before);
}

TEST(RunStudy, RefusesToGoOnWhereItWouldComputeOtherNumbers) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "s.sqlite";
  run_study(tiny_plan(2), path);
  rows_of(path, "UPDATE runs SET position_rmse_m = position_rmse_m * 1.000000000000001 WHERE method = 1");
  run_study(tiny_plan(2), path);  // nothing to do, nothing to compare
  const std::string message = message_of([&] { run_study(tiny_plan(3), path); });
  EXPECT_THAT(message, HasSubstr("computes other numbers: tiny, run 0, method 1: position_rmse_m"));
}

TEST(RunStudy, RecordsDivergedRunsAndKeepsThemOutOfEveryAverage) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "s.sqlite";
  run_study(tiny_plan(3, kHopeless + ",ekf"), path);
  EXPECT_EQ(rows_of(path,
                    "SELECT count(*) FROM runs WHERE method = 0 AND diverged_frame >= 1 AND "
                    "diverged_reason <> '' AND position_rmse_m IS NULL"),
            std::vector<std::string>{"3"});
  EXPECT_EQ(rows_of(path, "SELECT count(*) FROM runs WHERE method = 1 AND diverged_frame IS NULL"),
            std::vector<std::string>{"3"});
  const StudyDatabase study(path);
  const StudyCurve curve = study.curve(0, 0, CurveQuantity::kPositionSquaredError).value();
  for (std::size_t k = 0; k < curve.count.size(); ++k) {
    std::uint64_t alive = 0;
    for (const StudyRun& run : study.runs(0, 0)) {
      alive += k < run.diverged->frame ? 1 : 0;
    }
    EXPECT_EQ(curve.count[k], alive);
  }
  EXPECT_EQ(curve.count.back(), 0u);
}

TEST(RunStudy, GivesShardsThatDivideTheRuns) {
  const TemporaryFolder folder;
  std::uint64_t total = 0;
  for (std::uint64_t index = 1; index <= 3; ++index) {
    StudyOptions options = with_threads(1);
    options.shard = {index, 3};
    total += run_study(two_cases(5), folder.path() / std::to_string(index), options).progress.total;
  }
  EXPECT_EQ(total, 4u * 5u + 2u * 3u);
}

TEST(RunStudy, TellsItsProgress) {
  const TemporaryFolder folder;
  std::vector<StudyProgress> told;
  StudyOptions options = with_threads(1);
  options.progress = [&](const StudyProgress& progress) { told.push_back(progress); };
  run_study(tiny_plan(4), folder.path() / "s.sqlite", options);
  ASSERT_FALSE(told.empty());
  for (std::size_t k = 1; k < told.size(); ++k) {
    EXPECT_GE(told[k].runs, told[k - 1].runs);
    EXPECT_GE(told[k].share, told[k - 1].share);
  }
  EXPECT_EQ(told.back().runs, 12u);
  EXPECT_EQ(told.back().share, 1.0);
}

TEST(RunStudy, FailsWithTheReasonWhereAScenarioCannotBeSimulated) {
  const TemporaryFolder folder;
  StudyPlan plan = tiny_plan(3);
  plan.cases[0].scenario.trajectory = FileTrajectory{testing::write_text(
      folder.path() / "short.tum", "0 0 0 0 0 0 0 1\n0.5 1 0 0 0 0 0 1\n0.6 1 0 0 0 0 0 1\n")};
  EXPECT_THROW(run_study(plan, folder.path() / "s.sqlite"), DataError);
}

TEST(RunStudy, LeavesAlienFilesAlone) {
  const TemporaryFolder folder;
  const fs::path text = testing::write_text(folder.path() / "notes.txt", std::string(5000, 'n'));
  EXPECT_THAT(testing::data_error_of([&] { run_study(tiny_plan(1), text); }).what(), HasSubstr("a study"));
  EXPECT_EQ(testing::read_text(text), std::string(5000, 'n'));
  const fs::path path = folder.path() / "s.sqlite";
  run_study(tiny_plan(1), path);
  rows_of(path, "PRAGMA user_version = 77");
  EXPECT_THAT(testing::data_error_of([&] { run_study(tiny_plan(1), path); }).what(),
              HasSubstr("expected a study of version 3, found one of version 77"));
  rows_of(path, "PRAGMA application_id = 5");
  EXPECT_THAT(testing::data_error_of([&] { run_study(tiny_plan(1), path); }).what(),
              HasSubstr("found another SQLite database"));
}

TEST(ShardFromString, ReadsAShardAndRefusesTheRest) {
  EXPECT_EQ(shard_from_string("2/4").index, 2u);
  EXPECT_EQ(shard_from_string("2/4").count, 4u);
  for (const std::string text : {"", "1", "0/4", "5/4", "1/0", "1/", "/2", "1/2/3", "-1/2", "a/b", "1 /2"}) {
    EXPECT_THROW((void)shard_from_string(text), std::invalid_argument) << text;
  }
}

}  // namespace
}  // namespace limber
