// SPDX-License-Identifier: MIT
#include "limber/study/study_database.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "datasets/files.hpp"
#include "limber/simulate/simulator.hpp"
#include "limber/study/study_item.hpp"
#include "limber/study/study_table.hpp"
#include "study/tiny_study.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::kHopeless;
using testing::TemporaryFolder;
using testing::tiny_plan;
using testing::two_cases;

/// A finished study, for tests that only read.
class FinishedStudy : public ::testing::Test {
 protected:
  void SetUp() override { run_study(plan_, path_); }

  const TemporaryFolder folder_;
  const fs::path path_ = folder_.path() / "s.sqlite";
  const StudyPlan plan_ = two_cases(4);
};

TEST_F(FinishedStudy, SaysWhatItHolds) {
  const StudyDatabase study(path_);
  EXPECT_EQ(study.info().seed, 1u);
  EXPECT_EQ(study.info().program_version, program_version());
  ASSERT_EQ(study.info().cases.size(), 2u);
  const StudyCaseInfo& info = study.info().cases[1];
  EXPECT_EQ(info.name, "tiny_vision");
  EXPECT_EQ(info.start, StartMode::kGroundTruth);
  EXPECT_EQ(info.runs, 2u);
  EXPECT_EQ(info.finished, 2u);
  EXPECT_THAT(info.labels, ElementsAre("lcekf:full", "mono-left"));
  EXPECT_EQ(info.methods[1].method, Method::kMonoLeft);
  EXPECT_FALSE(info.scenario.use_imu);
  EXPECT_EQ(info.scenario_text, format_scenario(plan_.cases[1].scenario));
  EXPECT_EQ(info.frame_times.size(), 21u);
}

TEST_F(FinishedStudy, GivesBackEveryFigureToTheLastBit) {
  const StudyDatabase study(path_);
  for (std::size_t c = 0; c < 2; ++c) {
    for (std::uint64_t run = 0; run < plan_.cases[c].runs; ++run) {
      const ItemResult item = compute_item(plan_, c, run);
      for (std::size_t m = 0; m < item.methods.size(); ++m) {
        const StudyRun stored = study.runs(c, m).at(run);
        EXPECT_EQ(stored.run, run);
        EXPECT_EQ(stored.diverged.has_value(), item.methods[m].run.diverged.has_value());
        EXPECT_EQ(stored.figures.position_rmse_m, item.methods[m].run.figures.position_rmse_m);
        EXPECT_EQ(stored.figures.nis, item.methods[m].run.figures.nis);
        EXPECT_EQ(stored.figures.frames, item.methods[m].run.figures.frames);
        EXPECT_EQ(stored.figures.anees, item.methods[m].run.figures.anees);
      }
    }
  }
}

TEST_F(FinishedStudy, HasCurvesThatAreTheMeansOverTheRuns) {
  const StudyDatabase study(path_);
  const StudyCurve curve = study.curve(0, 1, CurveQuantity::kDeltaTx).value();
  ASSERT_EQ(curve.mean.size(), 21u);
  std::vector<double> sum(21, 0.0);
  for (std::uint64_t run = 0; run < 4; ++run) {
    const ItemResult item = compute_item(plan_, 0, run);
    for (const RunSeries& series : item.methods[1].series) {
      for (std::size_t k = 0; k < 21 && series.quantity == CurveQuantity::kDeltaTx; ++k) {
        sum[k] += series.values[k];
      }
    }
  }
  for (std::size_t k = 0; k < 21; ++k) {
    EXPECT_EQ(curve.count[k], 4u);
    EXPECT_NEAR(curve.mean[k], sum[k] / 4.0, 1e-15);
  }
  EXPECT_FALSE(study.curve(0, 0, CurveQuantity::kDeltaTx));
}

TEST_F(FinishedStudy, ShowsTheFirstRunAsAnExample) {
  const StudyDatabase study(path_);
  const ExampleRun example = study.example(0);
  EXPECT_EQ(example.truth.size(), 21u);
  EXPECT_GT(example.landmarks.size(), 5u);
  ASSERT_EQ(example.estimate.size(), 4u);
  const ItemResult item = compute_item(plan_, 0, 0);
  EXPECT_EQ(example.estimate[0], item.methods[0].positions);
  EXPECT_EQ(example.estimate[3].size(), item.methods[3].run.diverged->frame);
  EXPECT_LT((example.estimate[2].back() - example.truth.back()).norm(), 0.5);
}

TEST_F(FinishedStudy, RefusesIndicesThatDoNotExist) {
  const StudyDatabase study(path_);
  EXPECT_THROW((void)study.runs(2, 0), std::invalid_argument);
  EXPECT_THROW((void)study.runs(1, 2), std::invalid_argument);
  EXPECT_THROW((void)study.curve(1, 2, CurveQuantity::kPoseNees), std::invalid_argument);
  EXPECT_THROW((void)study.example(2), std::invalid_argument);
}

TEST_F(FinishedStudy, SummarizesWhatDidNotDivergeAndCountsWhatDid) {
  const StudyDatabase study(path_);
  const std::vector<MethodSummary> summaries = summarize_case(study, 0);
  ASSERT_EQ(summaries.size(), 4u);
  EXPECT_EQ(summaries[0].label, "ekf");
  EXPECT_EQ(summaries[0].runs, 4u);
  EXPECT_EQ(summaries[0].diverged, 0u);
  double squares = 0.0, worst = 0.0;
  for (const StudyRun& run : study.runs(0, 0)) {
    squares += *run.figures.position_rmse_m * *run.figures.position_rmse_m;
    worst = std::max(worst, *run.figures.position_rmse_m);
  }
  EXPECT_NEAR(*summaries[0].position_rmse_m, std::sqrt(squares / 4.0), 1e-12);
  EXPECT_EQ(*summaries[0].position_rmse_worst_m, worst);
  EXPECT_LT(summaries[0].anees_interval->lower, 1.0);
  EXPECT_GT(summaries[0].anees_interval->upper, 1.0);

  const MethodSummary& hopeless = summaries[3];
  EXPECT_EQ(hopeless.label, kHopeless);
  EXPECT_EQ(hopeless.runs, 4u);
  EXPECT_EQ(hopeless.diverged, 4u);
  EXPECT_GE(hopeless.first_diverged_t.value(), 0.05);
  EXPECT_FALSE(hopeless.position_rmse_m || hopeless.anees || hopeless.anees_interval || hopeless.scale);
  EXPECT_THAT(format_study_table(study), HasSubstr("4 (4 diverged, first at "));
}

TEST(StudyTable, CountsRunsThatDivergedAndRunsThatWereLost) {
  MethodSummary summary;
  summary.label = "ekf";
  summary.runs = 100;
  EXPECT_EQ(brief_rows({summary}).at(0).runs, "100");
  summary.lost = 1;
  EXPECT_EQ(brief_rows({summary}).at(0).runs, "100 (1 lost)");
  summary.diverged = 3;
  summary.first_diverged_t = 12.3;
  EXPECT_EQ(brief_rows({summary}).at(0).runs, "100 (3 diverged, first at 12.3 s; 1 lost)");
}

TEST(StudyTable, PutsTheMeanNeesOfManyRunsWithinItsBounds) {
  const TemporaryFolder folder;
  StudyPlan plan = tiny_plan(40, "oracle");
  plan.cases[0].scenario.duration = 3.0;
  run_study(plan, folder.path() / "s.sqlite");
  const MethodSummary oracle = summarize_case(StudyDatabase(folder.path() / "s.sqlite"), 0).at(0);
  // Seed 1, 40 runs: 240 d.o.f. at every instant, so that the bounds are 0.83 and 1.19.
  EXPECT_NEAR(oracle.anees_interval->lower, 0.83, 0.01);
  EXPECT_NEAR(oracle.anees_interval->upper, 1.19, 0.01);
  EXPECT_NEAR(*oracle.anees, 1.0, 0.2);
  EXPECT_GT(*oracle.share_within_interval, 0.7);
  EXPECT_LT(*oracle.anees_standard_error, 0.1);
}

TEST(StudyDatabase, CanBeReadWhileItIsWritten) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "s.sqlite";
  std::uint64_t seen = 0;
  StudyOptions options;
  options.threads = 2;
  options.progress = [&](const StudyProgress& progress) {
    const StudyDatabase study(path);
    seen = study.info().cases[0].finished;
    EXPECT_EQ(seen * 3, progress.runs);
  };
  run_study(tiny_plan(5), path, options);
  EXPECT_EQ(seen, 5u);
}

TEST(StudyDatabase, RefusesAStartThatItDoesNotKnow) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "s.sqlite";
  run_study(tiny_plan(1, "ekf"), path);
  testing::rows_of(path, "UPDATE cases SET start = 'guess'");
  try {
    const StudyDatabase study(path);
    ADD_FAILURE();
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), HasSubstr("expected a start 'auto' or 'groundtruth', found 'guess'"));
  }
}

TEST(StudyDatabase, RefusesWhatIsNoStudy) {
  const TemporaryFolder folder;
  const fs::path missing = folder.path() / "none.sqlite";
  EXPECT_THAT(testing::data_error_of([&] { (void)StudyDatabase(missing); }).what(),
              HasSubstr("no such file"));
  EXPECT_FALSE(fs::exists(missing));
  const fs::path text = testing::write_text(folder.path() / "a.txt", std::string(4096, 'a'));
  EXPECT_EQ(testing::data_error_of([&] { (void)StudyDatabase(text); }).file(), text.string());
  const fs::path empty = testing::write_text(folder.path() / "empty", "");
  EXPECT_THAT(testing::data_error_of([&] { (void)StudyDatabase(empty); }).what(),
              HasSubstr("another SQLite database"));
}

}  // namespace
}  // namespace limber
