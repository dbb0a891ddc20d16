// SPDX-License-Identifier: MIT
#include "limber/diagnose/overruled_since.hpp"
#include "limber/diagnose/judge_run.hpp"
#include "shipped_scenario.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <span>
#include <utility>
#include <vector>

namespace limber {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

constexpr std::int64_t kFrame = 100'000'000;  // [ns]

/// Ten seconds whose gate is overruled in some frames between the two.
std::vector<FrameReport> frames_overruled(std::size_t since, std::size_t until, std::size_t every = 1) {
  std::vector<FrameReport> out(100);
  for (std::size_t k = 0; k < out.size(); ++k) {
    out[k].t_ns = static_cast<std::int64_t>(k + 1) * kFrame;
    out[k].gate_overruled = since <= k && k < until && (k - since) % every == 0;
  }
  return out;
}

TEST(OverruledSince, IsTheFirstFrameOfSecondsInWhichMostAre) {
  EXPECT_EQ(overruled_since(frames_overruled(40, 100)), 41 * kFrame);
  EXPECT_EQ(overruled_since(frames_overruled(0, 100)), kFrame);
  EXPECT_EQ(overruled_since(frames_overruled(60, 80)), 61 * kFrame) << "two of three seconds";
}

TEST(OverruledSince, IsNeverWhereFewAreOrNotForLong) {
  EXPECT_FALSE(overruled_since(frames_overruled(40, 50))) << "a second: something large moved past";
  EXPECT_FALSE(overruled_since(frames_overruled(0, 100, 3)));
  const std::vector<FrameReport> frames = frames_overruled(0, 100);
  EXPECT_FALSE(overruled_since(std::span(frames).first(20))) << "two seconds";
  EXPECT_FALSE(overruled_since({}));
}

TEST(OverruledSince, LosesARunThatNoOdometryCarries) {
  const auto judged = [](MotionModel motion, std::optional<std::int64_t> lost_before) {
    RunRecord record;
    record.motion = motion;
    record.frames = frames_overruled(40, 100);
    RunSummary summary;
    summary.inputs.lost_since_ns = lost_before;
    add_overruled(record, summary);
    EXPECT_EQ(record.notes.size(), summary.inputs.lost_since_ns != lost_before ? 1U : 0U);
    return summary.inputs.lost_since_ns;
  };
  EXPECT_EQ(judged(MotionModel::kImu, {}), 41 * kFrame);
  EXPECT_EQ(judged(MotionModel::kConstantVelocity, {}), 41 * kFrame);
  EXPECT_FALSE(judged(MotionModel::kOdometry, {}));
  EXPECT_EQ(judged(MotionModel::kImu, 7 * kFrame), 7 * kFrame);
}

/// `ekf` followed a rig that is degrees off, by metres: exit code 0, and sigmas of centimetres.
TEST(OverruledSince, SaysThatARunIsLostWhoseRigIsDegreesOff) {
  const Recording log = simulate(testing::shipped("drone_none_vision", 12.0), 3);
  const auto judged = [&](Method method, const RigParameters& error) {
    RunOptions options;
    options.method = method;
    options.start = StartMode::kAuto;
    options.assume_error.head<6>() = error;
    RunRecord record = run_recording(log, options, matched_frames(log));
    const RunSummary summary = judge_run(log, options, {}, record);
    return std::pair(summary.inputs.lost_since_ns.has_value(), record.notes);
  };
  const RigParameters bent = 0.05 * RigParameters::Unit(0), sound = RigParameters::Zero();
  const auto [lost, notes] = judged(Method::kEkf, bent);
  EXPECT_TRUE(lost);
  EXPECT_THAT(notes, Contains(HasSubstr("the run is lost since")));
  EXPECT_FALSE(judged(Method::kEkf, sound).first);
  EXPECT_FALSE(judged(Method::kLcekf, bent).first);
}

}  // namespace
}  // namespace limber
