// SPDX-License-Identifier: MIT
#include "diagnosis.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "diagnose_recording.hpp"
#include "limber/core/angle.hpp"
#include "limber/core/divergence_error.hpp"
#include "limber/simulate/simulator.hpp"
#include "shipped_scenario.hpp"

namespace limber::app {
namespace {

using enum HealthVerdict;
using ::testing::HasSubstr;
using ::testing::Not;

Diagnosis with(HealthVerdict verdict) {
  Diagnosis out;
  out.dataset = "log";
  out.health.emplace();
  out.health->verdict = out.health->present.verdict = verdict;
  return out;
}

TEST(Diagnosis, HasAnExitCodeForEachVerdict) {
  EXPECT_EQ(exit_code(kOk), 0);
  EXPECT_EQ(exit_code(kDecalibrated), 3);
  EXPECT_EQ(exit_code(kCannotTell), 4);
  EXPECT_EQ(exit_code(kDegraded), 5);
}

TEST(Diagnosis, SaysWhatToDo) {
  EXPECT_THAT(to_text(with(kOk)), HasSubstr("What to do: nothing"));
  EXPECT_THAT(to_text(with(kDecalibrated)), HasSubstr("What to do: recalibrate"));
  EXPECT_THAT(to_text(with(kDegraded)), HasSubstr("What to do: recalibrate when you can"));
  EXPECT_THAT(to_text(with(kCannotTell)), HasSubstr("What to do: record more motion"));
}

TEST(Diagnosis, GivesTheAnswerFirstThenSizesAgainstTheTolerance) {
  Diagnosis diagnosis = with(kDecalibrated);
  CalibrationState& state = diagnosis.health->present;
  state.from_ns = 12'250'000'000;
  state.axes[1] = state.by_depth = kDecalibrated;
  state.named = 1;
  state.effect.depth = {0.25, 0.2, 0.3};
  diagnosis.health->past.emplace_back();
  diagnosis.pose = PoseLoss{120.0, 1.02, 1.5, 0.3};
  diagnosis.depths = {{10.0, -0.25, 0.01}, {20.0, std::nullopt, 0.0}};
  const std::string text = to_text(diagnosis);
  EXPECT_THAT(text,
              ::testing::StartsWith("log: decalibrated\nthe calibration is not that of this rig: 0.00 px"));
  EXPECT_THAT(text, HasSubstr("ekf drifts 1.50 m per 100 m from lcekf, scale 1.0200 (120 m)"));
  EXPECT_THAT(text, HasSubstr("since 12.2 s"));
  EXPECT_THAT(text, ::testing::ContainsRegex("depth at 90 baselines +25.000 +20.000 +30.000 +5 +10  %"));
  EXPECT_THAT(text, ::testing::ContainsRegex("ay  vergence.*deg decalibrated, explains it best"));
  EXPECT_THAT(text, HasSubstr("at 10 m  is wrong by -0.250 ± 0.010 m (-2.50 %)"));
  EXPECT_THAT(text, HasSubstr("at 20 m  cannot be measured"));
}

TEST(Diagnosis, CallsAMistakeDecalibratedWhateverTheMonitorSays) {
  Diagnosis diagnosis = with(kOk);
  diagnosis.mistakes = {"the two cameras are swapped"};
  EXPECT_EQ(verdict_of(diagnosis), kDecalibrated);
  EXPECT_THAT(to_text(diagnosis), HasSubstr("Looks like a mistake: the two cameras are swapped"));
}

TEST(Diagnosis, CannotTellOfARigWhoseRowsAreNotExposedAsAssumed) {
  Diagnosis diagnosis = with(kDecalibrated);
  diagnosis.readout_contradicted = "rolling shutter: 20 ms";
  EXPECT_EQ(verdict_of(diagnosis), kCannotTell);
  EXPECT_THAT(to_text(diagnosis),
              ::testing::StartsWith("log: cannot tell\nLooks like a mistake: rolling shutter: 20 ms\n"));
  EXPECT_THAT(to_text(diagnosis), HasSubstr("What to do: say how long an image takes (--readout-time"));
  diagnosis.mistakes = {"the two cameras are swapped"};
  EXPECT_EQ(verdict_of(diagnosis), kDecalibrated);
}

TEST(Diagnosis, MentionsATimeOffsetThatIsLargeAndCertain) {
  Diagnosis diagnosis = with(kOk);
  diagnosis.offsets.cam1 = TimeOffset{0.010, 0.001};
  EXPECT_THAT(to_text(diagnosis), HasSubstr("cam1 is taken 10.0 ± 1.0 ms later than stamped"));
  diagnosis.offsets.cam1 = TimeOffset{0.010, 0.005};
  EXPECT_THAT(to_text(diagnosis), Not(HasSubstr("time offset")));
}

TEST(Diagnosis, CannotTellOfARigThatAClockMayMakeLookWrong) {
  Diagnosis diagnosis = with(kDecalibrated);
  diagnosis.offsets.cameras = TimeOffset{0.020, 0.001};
  EXPECT_EQ(verdict_of(diagnosis), kCannotTell);
  EXPECT_THAT(to_text(diagnosis),
              ::testing::StartsWith("log: cannot tell\nLooks like a mistake: time offset: "));
  EXPECT_THAT(to_text(diagnosis), HasSubstr("the rig is not judged: a clock that is off"));
  EXPECT_THAT(to_text(diagnosis), HasSubstr("What to do: mend the clock"));
  diagnosis.mistakes = {"the two cameras are swapped"};
  EXPECT_EQ(verdict_of(diagnosis), kDecalibrated);
}

/// A run that is lost in its 30th frame.
Diagnosis lost_early(const Recording& recording) {
  bool lost = false;
  const auto until_lost = [&](std::size_t n) {
    if (n == 30 && !std::exchange(lost, true)) throw DivergenceError("the covariance is none");
    return recording.frames[n];
  };
  return diagnose_recording(recording, {}, {until_lost}, {}, {}, {});
}

/// A mistake may leave nothing to navigate with: the frames behind are looked at all the same.
TEST(Diagnosis, NamesTheMistakesOfARunThatWasLost) {
  Scenario scenario = testing::shipped("drone_none", 8.0);
  const Recording sound = simulate(scenario, 3);
  EXPECT_THROW((void)lost_early(sound), DivergenceError);
  Recording late = sound, in_degrees = sound;
  for (ImuSample& sample : late.imu) {
    sample.t_ns -= 100'000'000;
  }
  for (ImuSample& sample : in_degrees.imu) {
    sample.omega_imu *= kToDegrees;
  }
  const Diagnosis of_clock = lost_early(late), of_gyro = lost_early(in_degrees);
  EXPECT_EQ(verdict_of(of_clock), kCannotTell);
  EXPECT_THAT(to_text(of_clock), HasSubstr("the cameras are taken 100."));
  EXPECT_THAT(to_text(of_clock), HasSubstr("no run was possible: the covariance is none"));
  EXPECT_EQ(verdict_of(of_gyro), kDecalibrated);
  EXPECT_THAT(to_text(of_gyro), HasSubstr("deg/s instead of rad/s"));
}

TEST(Diagnosis, SaysWhyThereIsNoEkfBeside) {
  Diagnosis diagnosis = with(kDecalibrated);
  diagnosis.ekf_failure = "ekf diverged at frame 7";
  EXPECT_THAT(to_text(diagnosis), HasSubstr("What the pose loses: ekf fails: ekf diverged at frame 7\n"));
  EXPECT_EQ(nlohmann::json::parse(to_json(diagnosis))["ekf_failure"], "ekf diverged at frame 7");
}

TEST(Diagnosis, IsJsonWithNullForWhatIsNotKnown) {
  const auto json = nlohmann::json::parse(to_json(with(kDegraded)));
  EXPECT_EQ(json["verdict"], "degraded");
  EXPECT_EQ(json["health"]["verdict"], "degraded");
  EXPECT_TRUE(json["time_offset_cam1_cam0"].is_null() && json["failure"].is_null());
  EXPECT_TRUE(json["ekf_failure"].is_null());
}

}  // namespace
}  // namespace limber::app
