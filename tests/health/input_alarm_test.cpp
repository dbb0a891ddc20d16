// SPDX-License-Identifier: MIT
// When the images contradict the inputs, and when steps of the biases do.
#include "limber/health/input_alarm.hpp"

#include <gtest/gtest.h>

namespace limber {
namespace {

constexpr std::int64_t kFrameNs = 50'000'000;  // [ns]

/// A frame that corrects the pose by `sigmas` of what was to be expected.
PoseCorrection frame_of(int k, double sigmas) {
  PoseCorrection out;
  out.t_ns = k * kFrameNs;
  out.dt = 0.05;
  out.covariance = 1e-4 * PoseCorrection::Matrix6::Identity();
  out.dx = PoseCorrection::Vector6::Constant(0.01 * sigmas);
  out.nis = 100.0;
  out.dof = 100.0;
  return out;
}

StepFit fit_of(double explained, double factor = 1.0) {
  StepFit out;
  out.explained = explained;
  out.factor = factor;
  out.size = {0.03, 0.3};
  return out;
}

/// An alarm that has seen sound frames 1 to `frames`.
InputAlarm calm_after(int frames) {
  InputAlarm alarm;
  InputContradiction found;
  for (int k = 1; k <= frames; ++k) {
    EXPECT_FALSE(alarm.judge(frame_of(k, 0.3), fit_of(1.0), found));
  }
  return alarm;
}

TEST(InputAlarm, AStepIsFoundBeforeSingleFramesTell) {
  InputAlarm alarm = calm_after(20);
  InputContradiction found;
  EXPECT_FALSE(alarm.judge(frame_of(21, 0.3), fit_of(300.0), found));
  EXPECT_TRUE(alarm.active(21 * kFrameNs));  // it begins to show
  ASSERT_TRUE(alarm.judge(frame_of(22, 0.3), fit_of(400.0), found));
  EXPECT_TRUE(alarm.active(23 * kFrameNs));
  ASSERT_TRUE(found.step);
  EXPECT_EQ(found.step->gyro, 0.03);
  EXPECT_EQ(found.step->accel, 0.3);
  EXPECT_NEAR(found.statistic, alarm.statistic(), 1e-12);
}

/// What a clock does alternates as the motion does. Errors of pixels that last do not look like that.
TEST(InputAlarm, AStepOfTheClockAloneIsFoundSooner) {
  InputAlarm alarm = calm_after(20);
  InputContradiction found;
  StepFit fit = fit_of(120.0);
  EXPECT_FALSE(alarm.judge(frame_of(21, 0.3), fit, found));
  fit.explained_by_clock = 110.0;
  ASSERT_TRUE(alarm.judge(frame_of(22, 0.3), fit, found));
  EXPECT_TRUE(found.step);
  EXPECT_FALSE(found.clock_offset_ns) << "how far is not known yet";
}

TEST(InputAlarm, WhatARigMayDoIsNoStep) {
  InputAlarm alarm = calm_after(20);
  InputContradiction found;
  EXPECT_FALSE(alarm.judge(frame_of(21, 0.3), fit_of(400.0, 16.0), found));
  EXPECT_TRUE(alarm.judge(frame_of(22, 0.3), fit_of(800.0, 16.0), found));
}

TEST(InputAlarm, AStartSaysNothingOfAStep) {
  InputAlarm alarm = calm_after(5);
  InputContradiction found;
  EXPECT_FALSE(alarm.judge(frame_of(6, 0.3), fit_of(1e6), found));
}

TEST(InputAlarm, WhatASingleFrameShowsIsNoStep) {
  InputAlarm alarm = calm_after(20);
  InputContradiction found;
  ASSERT_TRUE(alarm.judge(frame_of(21, 30.0), fit_of(1e6), found));
  EXPECT_FALSE(found.step);
}

/// Corrections of 3 sigmas in every frame: their mean rejects, and a step is named if it explains them.
TEST(InputAlarm, WhatLastsIsAStepIfOneExplainsIt) {
  for (const bool explains : {false, true}) {
    InputAlarm alarm = calm_after(20);
    InputContradiction found;
    int k = 21;
    while (k < 60 && !alarm.judge(frame_of(k, 3.0), fit_of(explains ? 200.0 : 1.0), found)) ++k;
    ASSERT_LT(k, 60);
    EXPECT_EQ(found.step.has_value(), explains);
  }
}

/// Where half of the points begin to move with a body, the others contradict them: the pose is corrected by
/// what is worth little.
TEST(InputAlarm, PointsThatContradictEachOtherSayLittleOfTheInputs) {
  for (const double rows : {10.0, 300.0}) {  // NIS that the pose does not explain, of 94 degrees of freedom
    SCOPED_TRACE(rows);
    InputAlarm alarm;
    InputContradiction found;
    const auto frame = [](int k, double sigmas, double rest) {
      PoseCorrection out = frame_of(k, sigmas);
      out.nis = rest + 6.0 * sigmas * sigmas;
      return out;
    };
    for (int k = 1; k <= 100; ++k) {
      EXPECT_FALSE(alarm.judge(frame(k, 0.3, 10.0), fit_of(1.0), found));
      EXPECT_FALSE(alarm.points_quarrel());
    }
    const bool quarrel = rows > 10.0;
    EXPECT_EQ(alarm.judge(frame(101, 6.0, rows), fit_of(300.0), found), !quarrel);
    EXPECT_EQ(alarm.points_quarrel(), quarrel);
    if (quarrel) {  // nor later what steps make of it, while it is among the recent ones
      EXPECT_FALSE(alarm.judge(frame(102, 0.3, 10.0), fit_of(900.0), found));
      EXPECT_FALSE(alarm.points_quarrel());
    }
  }
}

TEST(InputAlarm, WhileTheStateIsOpenNoStepIsFound) {
  InputAlarm alarm = calm_after(20);
  InputContradiction found;
  ASSERT_TRUE(alarm.judge(frame_of(21, 30.0), {}, found));
  EXPECT_FALSE(alarm.judge(frame_of(22, 0.3), fit_of(1e6), found));
  const int later = 23 + static_cast<int>(InputAlarm::kCalm / 0.05);
  EXPECT_TRUE(alarm.judge(frame_of(later, 0.3), fit_of(1e6), found));
}

}  // namespace
}  // namespace limber
