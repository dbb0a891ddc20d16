// SPDX-License-Identifier: MIT
#include "limber/study/study_item.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "limber/diagnose/run_summary.hpp"
#include "limber/simulate/simulator.hpp"
#include "shipped_scenario.hpp"
#include "study/tiny_study.hpp"

namespace limber {
namespace {

using ::testing::HasSubstr;
using testing::kHopeless;
using testing::tiny_plan;

std::map<CurveQuantity, std::vector<double>> series_of(const MethodResult& result) {
  std::map<CurveQuantity, std::vector<double>> out;
  for (const RunSeries& series : result.series) {
    out[series.quantity] = series.values;
  }
  return out;
}

double root_mean(const std::vector<double>& squares) {
  double sum = 0.0;
  for (const double square : squares) {
    sum += square;
  }
  return std::sqrt(sum / static_cast<double>(squares.size()));
}

TEST(ComputeItem, JudgesEachMethodAsARunOnTheSameRecordingWouldBe) {
  const StudyPlan plan = tiny_plan(5);
  const ItemResult item = compute_item(plan, 0, 3);
  EXPECT_EQ(item.study_case, 0u);
  EXPECT_EQ(item.run, 3u);
  ASSERT_EQ(item.methods.size(), 3u);
  const Recording recording = simulate(plan.cases[0].scenario, plan.seed, 3);
  for (std::size_t k = 0; k < 3; ++k) {
    const RunOptions options =
        run_options(plan.cases[0].scenario, plan.cases[0].methods[k], plan.cases[0].start, plan.seed, 3);
    const RunSummary summary =
        summarize(recording, options, run_recording(recording, options, matched_frames(recording)));
    const StudyRun& run = item.methods[k].run;
    EXPECT_EQ(run.run, 3u);
    EXPECT_FALSE(run.diverged);
    EXPECT_EQ(run.figures.position_rmse_m, summary.position_rmse_m);
    EXPECT_EQ(run.figures.attitude_rmse_deg, summary.attitude_rmse_deg);
    EXPECT_EQ(run.figures.anees, summary.anees);
    EXPECT_EQ(run.figures.ate_sim3_m, summary.ate_sim3_m);
    EXPECT_EQ(run.figures.nis, summary.nis);
    EXPECT_EQ(run.figures.frames, 21);
  }
}

TEST(ComputeItem, KeepsSeriesThatAgreeWithTheFigures) {
  const ItemResult item = compute_item(tiny_plan(1), 0, 0);
  for (const MethodResult& method : item.methods) {
    const auto series = series_of(method);
    const RunFigures& figures = method.run.figures;
    EXPECT_NEAR(root_mean(series.at(CurveQuantity::kPositionSquaredError)), *figures.position_rmse_m, 1e-12);
    EXPECT_NEAR(root_mean(series.at(CurveQuantity::kAttitudeSquaredError)) * 180.0 / M_PI,
                *figures.attitude_rmse_deg, 1e-12);
    EXPECT_NEAR(std::sqrt(series.at(CurveQuantity::kLandmarkSquaredError).back()), *figures.landmark_rmse_m,
                1e-12);
    EXPECT_NEAR(std::sqrt(series.at(CurveQuantity::kPositionSquaredError).back()), *figures.position_final_m,
                1e-12);
    // Frames later than 1 s enter ANEES: here none.
    EXPECT_FALSE(figures.anees);
    for (const auto& [quantity, values] : series) {
      EXPECT_EQ(values.size(), 21u) << name_of(quantity);
    }
  }
}

TEST(ComputeItem, LeavesPointsOfAMovingBodyOutOfTheErrorOfTheMap) {
  StudyPlan plan = tiny_plan(1, "lcekf");
  plan.cases[0].scenario.world.moving_body = MovingBodyScenario{.share = 0.4};
  const auto landmarks = series_of(compute_item(plan, 0, 0).methods.front()).at(CurveQuantity::kLandmarks);
  const std::size_t known = simulate(plan.cases[0].scenario, plan.seed, 0).truth.landmarks.size();
  EXPECT_GT(landmarks.back(), 5.0);
  EXPECT_LE(landmarks.back(), static_cast<double>(known));
}

TEST(ComputeItem, CountsTheFramesOfAStartFromTheSensorsInTheWorldOfTheTruth) {
  for (const bool use_imu : {true, false}) {
    StudyPlan plan = tiny_plan(1, use_imu ? "ekf,ekf-full,lcekf,adaptive,mono-left" : "ekf");
    plan.cases[0].start = StartMode::kAuto;
    plan.cases[0].scenario.duration = 2.0;
    plan.cases[0].scenario.use_imu = use_imu;
    const ItemResult item = compute_item(plan, 0, 0);
    const Recording recording = simulate(plan.cases[0].scenario, plan.seed, 0);
    for (std::size_t k = 0; k < item.methods.size(); ++k) {
      const std::string label = to_string(plan.cases[0].methods[k]);
      const StudyRun& run = item.methods[k].run;
      ASSERT_FALSE(run.diverged) << label << ": " << run.diverged->reason;
      EXPECT_EQ(run.figures.frames, 41) << label;
      ASSERT_TRUE(run.figures.start_s && run.figures.anees_scale) << label;
      EXPECT_GT(*run.figures.start_s, 0.0) << label;
      const auto series = series_of(item.methods[k]);
      const auto& position = series.at(CurveQuantity::kPositionSquaredError);
      ASSERT_EQ(position.size(), 41u) << label;
      // Aligned at the first pose, window and all: the summary's figure.
      EXPECT_NEAR(position.front(), 0.0, 1e-18) << label;
      EXPECT_NEAR(root_mean(position), *run.figures.position_rmse_m, 1e-9) << label;
      EXPECT_NEAR(std::sqrt(position.back()), *run.figures.position_final_m, 1e-9) << label;
      double nees = 0.0;
      for (std::size_t n = 21; n < 41; ++n) {
        nees += series.at(CurveQuantity::kPoseNees)[n] / 6.0 / 20.0;
      }
      EXPECT_NEAR(nees, *run.figures.anees, 1e-6 * nees) << label;
      EXPECT_LT(
          (item.methods[k].positions.front() - recording.truth.motion.states.front().p_world_body).norm(),
          1e-9);
      EXPECT_LT(label == "ekf" ? *run.figures.landmark_rmse_m : 0.0, 5.0);  // where the truth has them
    }
  }
}

TEST(ComputeItem, FollowsThetaWhereItIsInTheState) {
  const ItemResult item = compute_item(tiny_plan(1), 0, 0);
  EXPECT_EQ(series_of(item.methods[0]).count(CurveQuantity::kDeltaTx), 0u);
  EXPECT_EQ(series_of(item.methods[2]).count(CurveQuantity::kDeltaTx), 0u);
  const auto full = series_of(item.methods[1]);
  const RigParameters delta = paper_decalibration();
  for (std::size_t axis = 0; axis < 6; ++axis) {
    const auto k = static_cast<Eigen::Index>(axis);
    const double estimate = full.at(theta_axis(CurveQuantity::kDeltaAx, axis)).back();
    const double squared_error = full.at(theta_axis(CurveQuantity::kThetaSquaredErrorAx, axis)).back();
    EXPECT_NEAR(squared_error, (estimate - delta(k)) * (estimate - delta(k)), 1e-15);
    EXPECT_GT(full.at(theta_axis(CurveQuantity::kThetaVarianceAx, axis)).back(), 0.0);
  }
  EXPECT_NEAR(full.at(CurveQuantity::kDeltaAz).back(), delta(2), 0.05 * M_PI / 180.0);
}

TEST(ComputeItem, KeepsThePathOfTheFirstRunOnly) {
  const StudyPlan plan = tiny_plan(2, "ekf");
  EXPECT_EQ(compute_item(plan, 0, 0).methods[0].positions.size(), 21u);
  EXPECT_TRUE(compute_item(plan, 0, 1).methods[0].positions.empty());
}

TEST(ComputeItem, LeavesGapsWhereFramesAreLost) {
  StudyPlan plan = tiny_plan(1, "ekf");
  plan.cases[0].scenario.dropout.frames = 0.5;
  const ItemResult item = compute_item(plan, 0, 0);
  const auto series = series_of(item.methods[0]);
  const auto& values = series.at(CurveQuantity::kPositionVariance);
  ASSERT_EQ(values.size(), 21u);
  const auto present = std::count_if(values.begin(), values.end(), [](double v) { return !std::isnan(v); });
  ASSERT_FALSE(item.methods[0].run.diverged) << item.methods[0].run.diverged->reason;
  EXPECT_EQ(present, item.methods[0].run.figures.frames);
  EXPECT_LT(present, 21);
}

TEST(ComputeItem, RecordsWhenAndWhyAMethodDivergedAndGoesOnWithTheOthers) {
  const ItemResult item = compute_item(tiny_plan(1, kHopeless + ",ekf"), 0, 0);
  const StudyRun& lost = item.methods[0].run;
  ASSERT_TRUE(lost.diverged);
  EXPECT_GE(lost.diverged->frame, 1u);
  EXPECT_LE(lost.diverged->frame, 20u);
  EXPECT_DOUBLE_EQ(lost.diverged->t, 0.05 * static_cast<double>(lost.diverged->frame));
  EXPECT_FALSE(lost.diverged->reason.empty());
  EXPECT_FALSE(lost.figures.position_rmse_m);
  EXPECT_FALSE(lost.figures.frames);
  EXPECT_FALSE(item.methods[1].run.diverged);
  // Its series end before the frame in which it was lost.
  for (const auto& [quantity, values] : series_of(item.methods[0])) {
    for (std::size_t k = 0; k < values.size(); ++k) {
      EXPECT_EQ(std::isnan(values[k]), k >= lost.diverged->frame) << name_of(quantity) << " " << k;
    }
  }
}

/// What is not the filter's fault is no result: it ends the study, and says where.
TEST(ComputeItem, TakesNothingElseForADivergence) {
  StudyPlan plan = tiny_plan(1, "ekf");
  plan.cases[0].methods[0] = method_variant_from_string("ekf:assume=tx=100");  // turns the baseline around
  try {
    (void)compute_item(plan, 0, 0);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("case 'tiny', run 0, method ekf:assume=tx=100: --assume-error"));
  }
}

TEST(ComputeItem, TakesAnAbsurdErrorForADivergence) {
  StudyPlan plan = tiny_plan(1, "ekf");
  plan.cases[0].scenario.initial.position = 5000.0;
  const StudyRun run = compute_item(plan, 0, 0).methods[0].run;
  ASSERT_TRUE(run.diverged);
  EXPECT_EQ(run.diverged->frame, 0u);
  EXPECT_THAT(run.diverged->reason, HasSubstr("the position is"));
}

TEST(ComputeItem, IsAPureFunctionButForTimings) {
  const StudyPlan plan = testing::two_cases(2);
  for (const std::size_t study_case : {0u, 1u}) {
    ItemResult a = compute_item(plan, study_case, 0), b = compute_item(plan, study_case, 0);
    for (ItemResult* const item : {&a, &b}) {
      for (MethodResult& method : item->methods) {
        method.run.figures.ms_per_frame_mean.reset();
        method.run.figures.ms_per_frame_p50.reset();
        method.run.figures.ms_per_frame_p99.reset();
      }
    }
    EXPECT_EQ(to_bytes(a), to_bytes(b));
  }
}

TEST(ComputeItem, StopsWhenItIsTold) {
  int frames = 0;
  EXPECT_THROW((void)compute_item(tiny_plan(1), 0, 0, [&] { return ++frames < 5; }), ItemCancelled);
  EXPECT_EQ(frames, 5);
}

TEST(ItemResult, GoesThroughBytesAndBack) {
  const ItemResult item = compute_item(tiny_plan(1, "ekf-full," + kHopeless), 0, 0);
  const std::string bytes = to_bytes(item);
  EXPECT_EQ(to_bytes(item_from_bytes(bytes)), bytes);
  EXPECT_EQ(item_from_bytes(bytes).methods[1].run.diverged->reason, item.methods[1].run.diverged->reason);
  EXPECT_THROW((void)item_from_bytes(bytes.substr(0, bytes.size() - 1)), std::invalid_argument);
  EXPECT_THROW((void)item_from_bytes(bytes + "x"), std::invalid_argument);
}

/// A run that goes on after its gyroscope stepped is none that `limber run` would end with exit code 0.
TEST(ComputeItem, SaysSinceWhenARunWasLost) {
  Scenario scenario = testing::shipped("drone_none", 14.0);
  scenario.faults = {GyroBiasStep{.at = 7.0, .size = 0.05}};
  scenario.filter.gate = true;  // what is refused is part of the evidence
  StudyPlan plan;
  plan.cases.push_back({scenario, method_variants_from_string("ekf,lcekf"), 1, StartMode::kGroundTruth});
  const ItemResult item = compute_item(plan, 0, 0);
  ASSERT_TRUE(item.methods[0].run.figures.lost_s);
  EXPECT_NEAR(*item.methods[0].run.figures.lost_s, 7.0, 2.0);
  EXPECT_FALSE(item.methods[1].run.figures.lost_s);
  plan.cases[0].scenario.faults.clear();
  for (const MethodResult& method : compute_item(plan, 0, 0).methods) {
    EXPECT_FALSE(method.run.figures.lost_s) << method.run.run;
  }
}

}  // namespace
}  // namespace limber
