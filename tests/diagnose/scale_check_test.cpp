// SPDX-License-Identifier: MIT
#include "limber/diagnose/scale_check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "limber/diagnose/judge_run.hpp"
#include "shipped_scenario.hpp"

namespace limber {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr std::size_t kAlong = 3;  // the axis of the baseline, tx

/// The first 26 s of a scenario.
Recording rover(const char* name, std::uint64_t seed) { return simulate(testing::shipped(name, 26.0), seed); }

struct JudgedRun {
  RunRecord record;
  RunSummary summary;
};

JudgedRun run_judged(const Recording& recording, Method method) {
  RunOptions options;
  options.method = method;
  JudgedRun out;
  out.record = run_recording(recording, options, matched_frames(recording));
  out.summary = judge_run(recording, options, {}, out.record);
  return out;
}

const auto kSaysTheScale = HasSubstr("its trajectory is");

/// 5 % of 2 m. The filter follows the length: its own windows have no idea, and were `ok`.
TEST(ScaleCheck, NamesABaselineThatEkfFollows) {
  const JudgedRun run = run_judged(rover("rover_baseline", 81), Method::kEkf);
  ASSERT_TRUE(run.summary.scale_check);
  const TrajectoryScale& scale = run.summary.scale_check->scale;
  EXPECT_NEAR(scale.too_long, 0.05, 3.0 * scale.sigma);
  EXPECT_LT(scale.sigma, 0.015);
  EXPECT_GE(scale.sigma, 0.01);
  EXPECT_THAT(
      run.record.notes,
      Contains(AllOf(HasSubstr("sigmas of ekf take the rig for exact"), kSaysTheScale,
                     HasSubstr("% too long, as of a baseline that is shorter than the assumed 2 m"))));
  EXPECT_THAT(run.summary.inputs.events, Contains(Field(&RunEvent::kind, RunEventKind::kTrustedScaleOff)));
  const CalibrationState& rig = run.summary.health->present;
  EXPECT_NE(run.summary.health->verdict, HealthVerdict::kOk);
  EXPECT_NE(rig.axes[kAlong], HealthVerdict::kOk);
  EXPECT_NEAR(rig.estimate.delta(kAlong), 0.1, 3.0 * rig.estimate.sigma()(kAlong));
  EXPECT_GT(rig.estimate.delta(kAlong), 2.0 * rig.estimate.sigma()(kAlong));
}

TEST(ScaleCheck, LeavesASoundRigAlone) {
  const Recording recording = rover("paper_i", 81);
  const JudgedRun run = run_judged(recording, Method::kEkf);
  ASSERT_TRUE(run.summary.scale_check);
  EXPECT_NEAR(run.summary.scale_check->scale.too_long, 0.0, 2.0 * run.summary.scale_check->scale.sigma);
  EXPECT_THAT(run.record.notes, Not(Contains(kSaysTheScale)));
  EXPECT_FALSE(is_wrong(run.summary.health->verdict));
  // A place that leaps once, as after a start of 20 s at 10 m/s that knew the scale to some per cent.
  RunRecord leaps = run.record;
  for (std::size_t k = leaps.trajectory.size() - 30; k < leaps.trajectory.size(); ++k) {
    leaps.trajectory[k].T_world_body.p += 8.0 * leaps.trajectory[k].v_world_body->normalized();
  }
  RunOptions options;
  options.method = Method::kEkf;
  const std::optional<ScaleCheck> check = check_scale(recording, options, leaps);
  ASSERT_TRUE(check);
  EXPECT_NEAR(check->scale.too_long, 0.0, 2.0 * check->scale.sigma);
}

TEST(ScaleCheck, IsOfMethodsThatTakeTheLengthForExact) {
  Scenario scenario = testing::shipped("drone_none", 8.0);
  const Recording recording = simulate(scenario, 3);
  const JudgedRun blind = run_judged(recording, Method::kLcekf);
  EXPECT_EQ(blind.record.last_frames.size(), recording.frames.size());  // for other questions
  EXPECT_FALSE(blind.summary.rests_on_length);
  EXPECT_FALSE(blind.summary.scale_check);
  const JudgedRun trusting = run_judged(recording, Method::kEkf);
  EXPECT_TRUE(trusting.summary.rests_on_length);
  ASSERT_TRUE(trusting.summary.scale_check);
  EXPECT_EQ(trusting.summary.scale_check->from_ns, recording.frames.front().t_ns);  // of the start, too
  EXPECT_EQ(trusting.summary.scale_check->to_ns, recording.frames.back().t_ns);
}

TEST(ScaleCheck, IsNoneOfVisionAloneWhosePositionsRestOnTheLength) {
  Scenario scenario = testing::shipped("drone_none", 8.0);
  Recording recording = simulate(scenario, 3);
  recording.imu.clear();
  const JudgedRun run = run_judged(recording, Method::kLcekf);
  EXPECT_TRUE(run.record.last_frames.empty());  // without an IMU nothing asks for them
  EXPECT_TRUE(run.summary.rests_on_length);
  EXPECT_FALSE(run.summary.scale_check);
}

/// `ok` would be about a length that nobody has seen.
TEST(ScaleCheck, WithoutOneTheLengthIsNotKnown) {
  Scenario scenario = testing::shipped("drone_none", 12.0);
  const Recording recording = simulate(scenario, 3);
  RunOptions options;
  options.method = Method::kEkf;
  RunRecord record = run_recording(recording, options, matched_frames(recording));
  ASSERT_EQ(summarize(recording, options, record).health->verdict, HealthVerdict::kOk);
  record.last_frames.clear();
  const RunSummary summary = judge_run(recording, options, {}, record);
  EXPECT_FALSE(summary.scale_check);
  EXPECT_EQ(summary.health->verdict, HealthVerdict::kCannotTell);
  EXPECT_EQ(summary.health->present.axes[kAlong], HealthVerdict::kCannotTell);
  EXPECT_EQ(summary.health->present.axes[0], HealthVerdict::kOk);
}

}  // namespace
}  // namespace limber
