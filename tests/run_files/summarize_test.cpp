// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "datasets/files.hpp"
#include "limber/core/so3.hpp"
#include "limber/run_files/calibration_file.hpp"
#include "limber/run_files/frames_file.hpp"
#include "run_files/judged_run.hpp"

namespace limber {
namespace {

using Json = nlohmann::json;
using testing::Judged;
using testing::short_recording;
using testing::without_truth;

TEST(Summarize, ComparesWithTheGroundTruth) {
  const Judged run(short_recording());
  EXPECT_EQ(run.summary.method, "lcekf");
  EXPECT_EQ(run.summary.dataset, "short");
  EXPECT_EQ(run.summary.frames, 41u);
  EXPECT_DOUBLE_EQ(run.summary.duration_s, 2.0);
  EXPECT_GT(run.summary.path_length_m, 0.1);
  ASSERT_TRUE(run.summary.position_rmse_m && run.summary.ate_none_m && run.summary.ate_se3_m);
  EXPECT_DOUBLE_EQ(*run.summary.position_rmse_m, *run.summary.ate_none_m);
  EXPECT_LE(*run.summary.ate_se3_m, *run.summary.ate_none_m);
  EXPECT_LE(run.summary.ate_sim3_m.value(), *run.summary.ate_se3_m + 1e-12);
  EXPECT_GT(run.summary.anees.value(), 0.01);
  EXPECT_LT(run.summary.anees.value(), 10.0);
  EXPECT_NEAR(run.summary.nis_per_dof.value(), 1.0, 0.3);
}

TEST(Summarize, CountsFramesPointsAndTime) {
  Judged run(short_recording());
  run.record.frame_ms.assign(41, 2.0);
  run.record.frame_ms[3] = 1.0;
  run.record.frame_ms[5] = 9.0;
  run.record.source_ms.assign(41, 3.0);
  const RunSummary summary = summarize(run.recording, run.options, run.record);
  EXPECT_EQ(summary.ms_per_frame_p50, 2.0);
  EXPECT_GE(summary.ms_per_frame_p99, 2.0);
  EXPECT_NEAR(summary.realtime_factor, 2000.0 / (39 * 2.0 + 10.0 + 41 * 3.0), 1e-9);
  EXPECT_FALSE(summary.start_ms);
  run.record.frames_of_start = 6;  // no filter saw them
  const RunSummary started = summarize(run.recording, run.options, run.record);
  EXPECT_EQ(started.start_ms, 4 * 2.0 + 10.0);
  EXPECT_EQ(started.start_worst_ms, 9.0);
  EXPECT_EQ(started.ms_per_frame_worst, 2.0);
  EXPECT_EQ(started.ms_per_frame_mean, 2.0);
  EXPECT_EQ(started.realtime_factor, summary.realtime_factor);
  double used = 0.0;
  for (const FrameReport& frame : run.record.frames) {
    used += static_cast<double>(frame.used);
  }
  EXPECT_NEAR(summary.points_per_frame, used / 41.0, 1e-12);
  EXPECT_GT(summary.peak_rss_mb, 1.0);
}

TEST(Summarize, LeavesOpenWhatOnlyTheTruthCouldTell) {
  const Judged run(without_truth(), StartMode::kAuto, Method::kEkf);
  const RunSummary& s = run.summary;
  EXPECT_FALSE(s.ate_none_m || s.ate_se3_m || s.ate_sim3_m || s.scale || s.position_rmse_m ||
               s.attitude_rmse_deg || s.anees || s.anees_position || s.anees_attitude);
  EXPECT_TRUE(s.nis_per_dof);
  EXPECT_GT(s.path_length_m, 0.0);
}

/// Half of it used to be the start, whatever that knew of the scale: ANEES 5, 2 and 43.
TEST(Summarize, FindsAShortRunFromTheSensorsAsSureAsItSays) {
  Scenario scenario = testing::short_scenario();
  scenario.duration = 3.0;
  for (const std::uint64_t seed : {501U, 502U, 503U}) {
    const Judged run(simulate(scenario, seed), StartMode::kAuto);
    ASSERT_TRUE(run.summary.anees);
    EXPECT_LT(*run.summary.anees, 2.5) << seed;
  }
}

TEST(Summarize, AlignsTheFirstPoseOfARunFromSensorsAlone) {
  Recording moved = short_recording();
  const Judged reference(moved, StartMode::kAuto);
  // The same motion seen from elsewhere in the world: shifted and turned about the vertical.
  const Eigen::Matrix3d R = so3_exp({0.0, 0.0, 1.0});
  for (GroundTruthState& state : moved.truth.motion.states) {
    state.p_world_body = R * state.p_world_body + Eigen::Vector3d(10.0, -20.0, 5.0);
    state.R_world_body = R * state.R_world_body;
  }
  const Judged elsewhere(moved, StartMode::kAuto);
  EXPECT_NEAR(*elsewhere.summary.position_rmse_m, *reference.summary.position_rmse_m, 1e-9);
  EXPECT_NEAR(*elsewhere.summary.attitude_rmse_deg, *reference.summary.attitude_rmse_deg, 1e-9);
  EXPECT_GT(std::abs(*elsewhere.summary.ate_none_m - *reference.summary.ate_none_m), 1.0);
}

TEST(Summarize, TakesTheTiltOfATruthThatIsNotLevelOutOfEveryError) {
  const Judged level(short_recording(), StartMode::kAuto);
  EXPECT_TRUE(level.summary.truth_is_level);
  EXPECT_LT(level.summary.truth_tilt_deg.value(), 3.0);
  Recording askew = short_recording();
  const Eigen::Matrix3d R = so3_exp({1.2, 0.3, 0.5});
  for (GroundTruthState& state : askew.truth.motion.states) {
    state.p_world_body = R * state.p_world_body;
    state.v_world_body = R * state.v_world_body;
    state.R_world_body = R * state.R_world_body;
  }
  const Judged run(askew, StartMode::kAuto);
  EXPECT_FALSE(run.summary.truth_is_level);
  EXPECT_GT(run.summary.truth_tilt_deg.value(), 60.0);
  EXPECT_THAT(run.summary.alignment, ::testing::HasSubstr("tilt of the truth's world"));
  // Two d.o.f. less are in the errors, so they are no larger but for the noise of the first pose.
  EXPECT_LT(*run.summary.attitude_rmse_deg, *level.summary.attitude_rmse_deg + 0.05);
  EXPECT_LT(*run.summary.position_rmse_m, 1.5 * *level.summary.position_rmse_m + 0.01);
  EXPECT_LT(*run.summary.anees, 2.0 * *level.summary.anees + 1.0);
  EXPECT_LT((run.summary.truth.back().T_world_body.R - run.record.trajectory.back().T_world_body.R).norm(),
            0.05);
  const Json json = Json::parse(summary_json(run.options, run.record, run.summary));
  EXPECT_EQ(json.at("truth_is_level"), false);
  EXPECT_THAT(json.at("answer").at("sentences").back().get<std::string>(), ::testing::HasSubstr("not level"));
  // Who starts from the truth is told what is down.
  EXPECT_FALSE(Judged(short_recording()).summary.truth_tilt_deg);
}

}  // namespace
}  // namespace limber
