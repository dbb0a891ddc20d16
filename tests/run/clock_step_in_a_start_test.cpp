// SPDX-License-Identifier: MIT
// An IMU whose stamps jump while the start still waits.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <optional>

#include "limber/diagnose/run_summary.hpp"
#include "limber/initialize/online_navigator.hpp"
#include "limber/run/run_recording.hpp"
#include "shipped_scenario.hpp"

namespace limber {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

Recording drone(std::int64_t offset_ns) {
  Recording recording = testing::realistic("drone_none", 16.0, 45);
  const std::int64_t at_ns = recording.frames.front().t_ns + 2'000'000'000;
  std::vector<ImuSample> imu;
  for (ImuSample sample : recording.imu) {
    sample.t_ns += sample.t_ns >= at_ns ? offset_ns : 0;
    if (imu.empty() || sample.t_ns > imu.back().t_ns) {  // samples that would run backwards are lost
      imu.push_back(sample);
    }
  }
  recording.imu = imu;
  return recording;
}

void expect_step_to_be_found(std::int64_t offset_ns) {
  const Recording recording = drone(offset_ns);
  RunOptions options;
  options.method = Method::kLcekf;
  const RunRecord record = run_recording(recording, options, matched_frames(recording));
  EXPECT_THAT(record.notes, Contains(HasSubstr("clock stepped between"))) << offset_ns;
  const RunSummary summary = summarize(recording, options, record);
  EXPECT_LE(summary.anees.value(), 2.5) << offset_ns;
  EXPECT_LE(summary.ate_se3_m.value(), 0.1) << offset_ns;
}

TEST(ClockStepInAStart, IsFoundAndSaidAndTheRunIsWhatItClaims) { expect_step_to_be_found(100'000'000); }

TEST(FullClockStepInAStart, IsFoundAndSaidAndTheRunIsWhatItClaims) { expect_step_to_be_found(-100'000'000); }

TEST(ClockStepInAStart, IsNotFoundWhereThereIsNone) {
  const Recording recording = drone(0);
  const RunRecord record = run_recording(recording, RunOptions{}, matched_frames(recording));
  EXPECT_THAT(record.notes, Not(Contains(HasSubstr("clock stepped"))));
}

/// As of cameras that nobody has synchronised with their IMU.
void expect_offset_to_be_found(double offset_s, Method method) {
  Recording recording = testing::realistic("drone_none", 16.0, 46);
  for (ImuSample& sample : recording.imu) {
    sample.t_ns += std::llround(1e9 * offset_s);
  }
  RunOptions options;
  options.method = method;
  const RunRecord record = run_recording(recording, options, matched_frames(recording));
  EXPECT_THAT(record.notes, Contains(HasSubstr("than they are stamped, by the images"))) << offset_s;
  const RunSummary summary = summarize(recording, options, record);
  EXPECT_LE(summary.anees.value(), 2.5) << offset_s;
  EXPECT_LE(summary.ate_se3_m.value(), 0.05) << offset_s;
}

TEST(ClockThatIsOff, IsFoundAndSaidAndTheRunIsWhatItClaims) {
  expect_offset_to_be_found(0.1, Method::kLcekf);
  expect_offset_to_be_found(-0.012, Method::kEkf);
}

TEST(FullClockThatIsOff, IsFoundAndSaidAndTheRunIsWhatItClaims) {
  for (const double offset_s : {-0.1, 0.012, 0.2}) {
    for (const Method method : {Method::kEkf, Method::kLcekf, Method::kAdaptive}) {
      expect_offset_to_be_found(offset_s, method);
    }
  }
}

TEST(ClockThatIsOff, IsNotSaidOfOneThatIsNot) {
  const Recording recording = drone(0);
  const RunRecord record = run_recording(recording, {}, matched_frames(recording));
  EXPECT_THAT(record.notes, Not(Contains(HasSubstr("than they are stamped"))));
}

TEST(ClockThatIsOff, IsLeftAloneWhereItIsStated) {
  const Recording recording = drone(0);
  RunOptions options;
  EXPECT_TRUE(set_up_run(recording, options).navigator.learn_imu_clock);
  options.learn_imu_clock = false;
  EXPECT_FALSE(set_up_run(recording, options).navigator.learn_imu_clock);
  options.learn_imu_clock = true;
  options.start = StartMode::kGroundTruth;
  EXPECT_FALSE(set_up_run(recording, options).navigator.learn_imu_clock);
}

/// The samples that come later are corrected, too.
TEST(ClockStepInAStart, IsKnownToTheOnlineNavigator) {
  const Recording recording = drone(-100'000'000);
  RunOptions options;
  options.method = Method::kLcekf;
  const RunSetup setup = set_up_run(recording, options);
  OnlineNavigator navigator(setup.navigator, setup.calibration);
  std::size_t next = 0;
  std::optional<std::int64_t> started_ns;
  for (const StereoFrame& frame : recording.frames) {
    for (; next < recording.imu.size() && (next == 0 || recording.imu[next - 1].t_ns < frame.t_ns); ++next) {
      navigator.add_imu(recording.imu[next]);
    }
    const OnlineReport report = navigator.process(frame);
    if (report.frame) {
      EXPECT_FALSE(report.frame->inputs.contradiction) << frame.t_ns;
      started_ns = started_ns.value_or(frame.t_ns);
    }
    if (started_ns && frame.t_ns > *started_ns + 2'000'000'000) {
      break;
    }
  }
  EXPECT_TRUE(navigator.started());
}

TEST(StampJump, TellsWhenASampleWasTaken) {
  const StampJump late{1000, 1100, 50};
  EXPECT_EQ(late.corrected(1000), 1000);
  EXPECT_FALSE(late.corrected(1050));
  EXPECT_FALSE(late.corrected(1150));
  EXPECT_EQ(late.corrected(1160), 1110);
  const StampJump early{1000, 1100, -50};
  EXPECT_FALSE(early.corrected(1100));
  EXPECT_EQ(early.corrected(1101), 1151);
  const StampJump all_along{.offset_ns = 50, .offset_before_ns = 50};
  EXPECT_FALSE(all_along.jumps());
  EXPECT_EQ(all_along.corrected(-1000), -1050);
  EXPECT_EQ(all_along.corrected(1000), 950);
  const StampJump both{1000, 1100, 50, 20};
  EXPECT_TRUE(both.jumps());
  EXPECT_EQ(both.corrected(1020), 1000);
  EXPECT_FALSE(both.corrected(1110));
  EXPECT_EQ(both.corrected(1160), 1110);
}

}  // namespace
}  // namespace limber
