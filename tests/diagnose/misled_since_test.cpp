// SPDX-License-Identifier: MIT
#include "limber/diagnose/misled_since.hpp"
#include "shipped_scenario.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace limber {
namespace {

using ::testing::Contains;

constexpr std::int64_t kFrame = 100'000'000;  // [ns]

/// Ten seconds in which from `since` on (a frame) NIS is `grown` times as large and a tenth of the points
/// goes.
std::vector<FrameReport> frames_that_grow(std::size_t since, std::size_t until, double grown) {
  std::vector<FrameReport> out(100);
  for (std::size_t k = 0; k < out.size(); ++k) {
    const bool bad = since <= k && k < until;
    out[k].t_ns = static_cast<std::int64_t>(k + 1) * kFrame;
    out[k].sigma_px = 0.5;
    out[k].dof = 200;
    out[k].nis = 200.0 * (bad ? grown : 1.0) * (1.0 + 0.2 * std::sin(static_cast<double>(k)));
    out[k].used = bad ? 45 : 50;
    out[k].refused.resize(bad ? 5 : 0);
  }
  return out;
}

std::optional<HealthSummary> rig(HealthVerdict verdict) {
  HealthSummary out;
  out.verdict = verdict;
  return out;
}

TEST(MisledSince, IsWhereTheMisfitBeganToGrowAndStayed) {
  const std::vector<FrameReport> frames = frames_that_grow(50, 100, 10.0);
  EXPECT_EQ(misled_since(frames, rig(HealthVerdict::kOk)), 51 * kFrame);
  EXPECT_EQ(misled_since(frames, rig(HealthVerdict::kCannotTell)), 51 * kFrame);
}

/// What grows within two seconds is an input's fault, what takes longer may be a rig that drifts away.
TEST(MisledSince, MayBeginInTheMidstOfASecond) {
  const auto grows_over = [](int frames) {
    std::vector<FrameReport> out = frames_that_grow(50, 100, 10.0);
    for (std::size_t k = 50; k < 50 + static_cast<std::size_t>(frames); ++k) {
      out[k].nis *= 0.4;
    }
    return misled_since(out, rig(HealthVerdict::kOk));
  };
  EXPECT_EQ(grows_over(10), 51 * kFrame);
  EXPECT_FALSE(grows_over(20));
}

TEST(MisledSince, IsNeverWhereARigThatIsWrongOrChangedExplainsIt) {
  const std::vector<FrameReport> frames = frames_that_grow(50, 100, 10.0);
  EXPECT_FALSE(misled_since(frames, rig(HealthVerdict::kDecalibrated)));
  EXPECT_FALSE(misled_since(frames, rig(HealthVerdict::kDegraded)));
  std::optional<HealthSummary> changed = rig(HealthVerdict::kOk);
  changed->past.resize(1);
  EXPECT_FALSE(misled_since(frames, changed));
  EXPECT_FALSE(misled_since(frames, std::nullopt));
}

TEST(MisledSince, IsNeverWhereTheMisfitIsAsUsualOrOverSoonOrThereFromTheBegin) {
  const auto rig_ok = rig(HealthVerdict::kOk);
  EXPECT_FALSE(misled_since(frames_that_grow(50, 100, 3.0), rig_ok));
  EXPECT_FALSE(misled_since(frames_that_grow(50, 70, 10.0), rig_ok));
  EXPECT_FALSE(misled_since(frames_that_grow(0, 100, 10.0), rig_ok));
  EXPECT_FALSE(misled_since({}, rig_ok));
}

/// A sigma that is learned and falls makes NIS grow, and the gate narrower, though no pixel is further off.
TEST(MisledSince, IsNeverWhereOnlyTheAssumedNoiseFalls) {
  std::vector<FrameReport> frames = frames_that_grow(50, 100, 10.0);
  for (std::size_t k = 50; k < frames.size(); ++k) {
    frames[k].sigma_px /= std::sqrt(10.0);
  }
  EXPECT_FALSE(misled_since(frames, rig(HealthVerdict::kOk)));
}

TEST(MisledSince, LosesARunWithoutAnImuSinceItsBodyLeapt) {
  const auto lost = [](MotionModel motion, bool leapt) {
    RunRecord record;
    record.motion = motion;
    record.frames.resize(10);
    record.trajectory.resize(10);
    RunSummary summary;
    if (leapt) summary.inputs.events.push_back({RunEventKind::kLeapt, 4'950'000'000, 5'000'000'000});
    add_misled({}, {}, record, summary);
    EXPECT_EQ(record.notes.size(), summary.inputs.lost_since_ns ? 1U : 0U);
    return summary.inputs.lost_since_ns;
  };
  EXPECT_EQ(lost(MotionModel::kOdometry, true), 5'000'000'000);
  EXPECT_EQ(lost(MotionModel::kConstantVelocity, true), 5'000'000'000);
  EXPECT_FALSE(lost(MotionModel::kOdometry, false));
  EXPECT_FALSE(lost(MotionModel::kImu, true));
}

/// A drone of sixteen seconds.
Recording drone(std::uint64_t seed) { return simulate(testing::shipped("drone_none", 16.0), seed); }

std::int64_t eighth_second(const Recording& log) { return log.frames.front().t_ns + 8'000'000'000; }

InputSummary judged(const Recording& log, Method method, bool learn_imu_noise = true) {
  RunOptions options;
  options.method = method;
  options.learn_imu_noise = learn_imu_noise;
  RunRecord record = run_recording(log, options, matched_frames(log));
  RunSummary summary = summarize(log, options, record);
  add_misled(log, options, record, summary);
  EXPECT_EQ(summary.inputs.lost_since_ns.has_value(),
            !record.notes.empty() && record.notes.back().find("the run is lost since") == 0);
  return summary.inputs;
}

/// Stamps that jump by 0.1 s, or a gyro by 0.05 rad/s, eight seconds before the end.
TEST(MisledSince, SaysSinceWhenEkfIsLostAfterAnInputFailedAndNothingOfASoundRun) {
  const Recording recording = drone(131);
  EXPECT_FALSE(judged(recording, Method::kEkf).lost_since_ns);
  const std::int64_t at_ns = eighth_second(recording);
  Recording stepped = recording;
  for (ImuSample& sample : stepped.imu) {
    sample.t_ns += sample.t_ns >= at_ns ? kFrame : 0;
  }
  const InputSummary late = judged(stepped, Method::kEkf);
  ASSERT_TRUE(late.lost_since_ns);
  EXPECT_NEAR(1e-9 * static_cast<double>(*late.lost_since_ns - at_ns), 0.0, 2.0);
  EXPECT_THAT(late.events,
              Contains(::testing::Field(&RunEvent::kind,
                                        ::testing::AnyOf(RunEventKind::kMisled, RunEventKind::kBiasMoved))));
  Recording turned = recording;
  for (ImuSample& sample : turned.imu) {
    sample.omega_imu.x() += sample.t_ns >= at_ns ? 0.05 : 0.0;
  }
  EXPECT_TRUE(judged(turned, Method::kEkf).lost_since_ns);
}

/// The run as if its points had contradicted each other from the eighth second on, and it had gone that many
/// times as fast.
RunRecord contested(RunRecord record, std::int64_t since_ns, double faster) {
  for (std::size_t k = 0; k < record.frames.size(); ++k) {
    FrameReport& frame = record.frames[k];
    if (frame.t_ns >= since_ns) {
      frame.nis *= 50.0;
      frame.refused.resize(frame.used);
      *record.trajectory[k].v_world_body *= faster;
    }
  }
  return record;
}

/// Innovations and refusals grow for a body that moves as after a fault of the IMU, but poses are right.
TEST(MisledSince, IsNotWhereTheTrajectoryIsThatOfAMethodThatAsksTheImuAlone) {
  const Recording recording = drone(131);
  RunOptions options;
  options.method = Method::kEkf;
  const RunRecord sound = run_recording(recording, options, matched_frames(recording));
  const auto is_lost = [&](double faster) {
    RunRecord record = contested(sound, eighth_second(recording), faster);
    RunSummary summary = summarize(recording, options, record);
    EXPECT_TRUE(misled_since(record.frames, summary.health));
    add_misled(recording, options, record, summary);
    return summary.inputs.lost_since_ns.has_value();
  };
  EXPECT_FALSE(is_lost(1.0));
  EXPECT_TRUE(is_lost(1.3));
}

/// As if the accelerometer's bias stepped at the eighth second [m/s^2].
Recording pushed(Recording log, double step) {
  const std::int64_t at_ns = eighth_second(log);
  for (ImuSample& sample : log.imu) {
    sample.accel_imu.y() += sample.t_ns >= at_ns ? step : 0.0;
  }
  return log;
}

/// A baseline that is 5 % too long, and an IMU that knows better: the accelerometer's bias gives way.
TEST(MisledSince, LeavesOpenThatTheRigIsOffWhereItMayBe) {
  const auto lost_note = [](const Recording& log) {
    RunOptions options;
    options.method = Method::kEkf;
    RunRecord record = run_recording(log, options, matched_frames(log));
    RunSummary summary = summarize(log, options, record);
    add_misled(log, options, record, summary);
    EXPECT_TRUE(summary.inputs.lost_since_ns);
    return record.notes.back();
  };
  Scenario scenario = testing::shipped("drone_baseline");
  scenario.duration = 28.0;  // eleven windows: enough to know 6 mm of the baseline by 3.5 sigmas
  EXPECT_THAT(lost_note(simulate(scenario, 7)), ::testing::HasSubstr(", or the rig is off, by tx +"));
  EXPECT_THAT(lost_note(pushed(drone(132), 0.12)), ::testing::Not(::testing::HasSubstr("or the rig")));
}

TEST(MisledSince, LosesAFilterThatFoundAStepLate) {
  const auto judged_by = [](std::optional<std::int64_t> astray_since_ns, HealthVerdict verdict) {
    RunRecord record;
    record.motion = MotionModel::kImu;
    record.frames = frames_that_grow(0, 0, 1.0);
    record.trajectory.resize(record.frames.size());
    record.frames[60].inputs.contradiction = InputContradiction{};
    record.frames[60].inputs.contradiction->astray_since_ns = astray_since_ns;
    RunSummary summary;
    summary.health = rig(verdict);
    add_misled({}, {}, record, summary);
    EXPECT_EQ(record.notes.size(), astray_since_ns ? 1U : 0U);
    return summary.inputs.lost_since_ns;
  };
  EXPECT_EQ(judged_by(5'000'000'000, HealthVerdict::kOk), 5'000'000'000);
  EXPECT_FALSE(judged_by(5'000'000'000, HealthVerdict::kDecalibrated));
  EXPECT_FALSE(judged_by(std::nullopt, HealthVerdict::kOk));
}

/// Innovations of single frames do not show a step of 0.12 m/s^2, those of a second together do.
TEST(MisledSince, LosesNoMethodThatNoticesTheStep) {
  const Recording recording = drone(132);
  for (const bool learns_noise : {false, true}) {
    EXPECT_FALSE(judged(recording, Method::kLcekf, learns_noise).lost_since_ns);
    const InputSummary noticed = judged(pushed(recording, 0.12), Method::kLcekf, learns_noise);
    EXPECT_FALSE(noticed.lost_since_ns);
    if (!learns_noise) {
      EXPECT_THAT(noticed.events, Contains(::testing::Field(&RunEvent::kind, RunEventKind::kContradicted)));
    }
  }
}

TEST(MisledSince, LosesNoMethodThatNoticesALargeStep) {
  const InputSummary noticed = judged(pushed(drone(132), 0.5), Method::kLcekf);
  EXPECT_THAT(noticed.events, Contains(::testing::Field(&RunEvent::kind, RunEventKind::kContradicted)));
  EXPECT_FALSE(noticed.lost_since_ns);
}

TEST(FullMisledSince, SaysSinceWhenAMethodIsLostWhoseBiasMovedFurtherThanItsSigmas) {
  const Recording recording = drone(132);
  for (const Method method : {Method::kEkf, Method::kEkfFull}) {
    EXPECT_FALSE(judged(recording, method).lost_since_ns);
    const InputSummary summary = judged(pushed(recording, 0.12), method, false);
    ASSERT_TRUE(summary.lost_since_ns) << to_string(method);
    EXPECT_NEAR(1e-9 * static_cast<double>(*summary.lost_since_ns - eighth_second(recording)), 0.0, 2.0);
  }
}

}  // namespace
}  // namespace limber
