// SPDX-License-Identifier: MIT
#include "limber/predict/input_buffer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "random_geometry.hpp"

namespace limber {
namespace {

using Eigen::Vector3d;
using testing::Generator;

constexpr std::int64_t kMs = 1000000;

/// Inputs that are linear in time, so that interpolation is exact: angular = t e_x, linear =
/// (1 - 2t) e_y.
InputSample linear_sample(std::int64_t t_ns) {
  const double t = 1e-9 * static_cast<double>(t_ns);
  return {t_ns, t * Vector3d::UnitX(), (1.0 - 2.0 * t) * Vector3d::UnitY()};
}

/// Samples every 5 ms from 0 up to and including `last_ms`.
InputBuffer regular(std::int64_t last_ms) {
  InputBuffer buffer;
  for (std::int64_t t = 0; t <= last_ms; t += 5) {
    buffer.add(linear_sample(t * kMs));
  }
  return buffer;
}

/// Steps that follow each other without a hole, from begin to end.
void expect_cover(const std::vector<InputStep>& steps, std::int64_t begin_ns, std::int64_t end_ns) {
  ASSERT_FALSE(steps.empty());
  std::int64_t t = begin_ns;
  for (const InputStep& step : steps) {
    EXPECT_GT(step.t_end_ns, t);
    EXPECT_DOUBLE_EQ(step.dt, 1e-9 * static_cast<double>(step.t_end_ns - t));
    t = step.t_end_ns;
  }
  EXPECT_EQ(t, end_ns);
}

TEST(InputBuffer, GivesNoStepsWithoutTime) {
  const InputBuffer buffer = regular(20);
  EXPECT_TRUE(buffer.steps(10 * kMs, 10 * kMs).empty());
  EXPECT_TRUE(buffer.steps(10 * kMs, 5 * kMs).empty());
}

TEST(InputBuffer, WithoutAnySampleKnowsNothingButThePrior) {
  const InputBuffer empty;
  const std::vector<InputStep> steps = empty.steps(0, 230 * kMs);
  expect_cover(steps, 0, 230 * kMs);
  for (const InputStep& step : steps) {
    EXPECT_LE(step.dt, 0.05);
    EXPECT_EQ(step.angular_unknown.memory, 0.0);
    EXPECT_GE(step.angular_unknown.density, 0.5 * kImuPrior.angular.spread * kImuPrior.angular.spread);
    EXPECT_GE(step.linear_unknown.density, 0.5 * kImuPrior.linear.spread * kImuPrior.linear.spread);
  }
  EXPECT_NEAR(empty.longest_gap_s(0, 230 * kMs), 0.23, 1e-12);
}

/// Swings with 1 rad/s and 3 m/s^2 of amplitude, and 0.5 Hz.
InputSample swinging_sample(std::int64_t t_ns, double amplitude = 1.0) {
  const double phase = 3.14e-9 * static_cast<double>(t_ns);
  return {t_ns, amplitude * std::sin(phase) * Vector3d::UnitX(),
          amplitude * 3.0 * std::cos(phase) * Vector3d::UnitY() + 9.81 * Vector3d::UnitZ()};
}

InputBuffer swinging(double seconds, double amplitude) {
  InputBuffer buffer;
  for (std::int64_t t = 0; t <= static_cast<std::int64_t>(seconds * 1e9); t += 5 * kMs) {
    buffer.add(swinging_sample(t, amplitude));
  }
  return buffer;
}

TEST(InputBuffer, WhatMayHaveHappenedInAGapGrowsWithItAndIsBoundedByTheMotionSeen) {
  const InputBuffer lively = swinging(40.0, 1.0), calm = swinging(40.0, 0.1);
  const std::int64_t end = 40000 * kMs;
  const std::vector<InputStep> steps = lively.steps(end, end + 2000 * kMs);
  double before = 0.0;
  for (const InputStep& step : steps) {
    EXPECT_GE(step.angular_unknown.density, before);
    EXPECT_LE(step.angular_unknown.density, 0.7 * 0.7 + 0.2);
    before = step.angular_unknown.density;
  }
  EXPECT_GE(steps.front().angular_unknown.memory, 0.95);
  EXPECT_EQ(steps.back().angular_unknown.memory, 0.0);
  EXPECT_LE(steps.front().angular_unknown.density, 0.05 * before);
  // A tenth of the motion: a hundredth of the variance (and what is left of the prior).
  const InputStep last = calm.steps(end, end + 2000 * kMs).back();
  EXPECT_LE(last.angular_unknown.density, 0.1 * before);
}

TEST(InputBuffer, BetweenSamplesNothingIsUnknown) {
  const InputBuffer buffer = swinging(1.0, 1.0);
  for (const InputStep& step : buffer.steps(0, 1000 * kMs)) {
    EXPECT_EQ(step.angular_unknown.density, 0.0);
    EXPECT_EQ(step.linear_unknown.density, 0.0);
    EXPECT_EQ(step.angular_unknown.memory, 1.0);
  }
  EXPECT_EQ(buffer.longest_gap_s(0, 1000 * kMs), 0.0);
}

/// The error of a prediction through a gap, against what the steps say of it: over many phases of a swing the
/// mean square of the angle's error stays below twice its variance, and is not ten times smaller.
TEST(InputBuffer, TheVarianceOfAGapIsThatOfTheErrorMade) {
  for (const std::int64_t gap_ms : {100, 300, 1000}) {
    double squared = 0.0, variance = 0.0;
    for (int run = 0; run < 40; ++run) {
      const std::int64_t from = (20000 + 137 * run) / 5 * 5 * kMs, to = from + gap_ms * kMs;
      InputBuffer buffer;
      for (std::int64_t t = 0; t <= to + 100 * kMs; t += 5 * kMs) {
        if (t <= from || t >= to) {
          buffer.add(swinging_sample(t));
        }
      }
      double angle = 0.0;
      for (const InputStep& step : buffer.steps(from, to)) {
        angle += step.angular_unknown.memory * step.angular.x() * step.dt;
        variance += step.angular_unknown.density * step.dt;
      }
      const auto integral = [](std::int64_t t) { return -std::cos(3.14e-9 * static_cast<double>(t)) / 3.14; };
      squared += std::pow(angle - (integral(to) - integral(from)), 2);
    }
    EXPECT_LE(squared, 2.0 * variance) << gap_ms;
    if (gap_ms == 1000) {
      EXPECT_GE(squared, 0.1 * variance) << gap_ms;
    }
  }
}

TEST(InputBuffer, EndsAStepAtEverySampleAndAtTheFrame) {
  InputBuffer buffer = regular(100);
  const std::vector<InputStep> steps = buffer.steps(2 * kMs, 13 * kMs);
  expect_cover(steps, 2 * kMs, 13 * kMs);
  ASSERT_EQ(steps.size(), 3U);
  EXPECT_EQ(steps[0].t_end_ns, 5 * kMs);
  EXPECT_EQ(steps[1].t_end_ns, 10 * kMs);
}

TEST(InputBuffer, FramesThatFallOnSamplesMakeNoEmptyStep) {
  InputBuffer buffer = regular(100);
  const std::vector<InputStep> steps = buffer.steps(5 * kMs, 15 * kMs);
  expect_cover(steps, 5 * kMs, 15 * kMs);
  EXPECT_EQ(steps.size(), 2U);
}

TEST(InputBuffer, CoversAnyIntervalsWithMeansOfTheInterpolatedInputs) {
  Generator generator(1);
  for (int run = 0; run < 20; ++run) {
    InputBuffer buffer;
    std::int64_t t_sample = 0;
    std::int64_t t_state = 0;
    while (t_state < 1000 * kMs) {
      const std::int64_t t_frame =
          t_state + std::uniform_int_distribution<std::int64_t>(1, 60 * kMs)(generator);
      while (t_sample < t_frame) {
        buffer.add(linear_sample(t_sample));
        t_sample += std::uniform_int_distribution<std::int64_t>(1, 20 * kMs)(generator);
      }
      buffer.add(linear_sample(t_sample));  // one beyond the frame: nothing has to be held
      t_sample += kMs;
      const std::vector<InputStep> steps = buffer.steps(t_state, t_frame);
      expect_cover(steps, t_state, t_frame);
      std::int64_t t = t_state;
      for (const InputStep& step : steps) {
        const double middle = 0.5e-9 * static_cast<double>(t + step.t_end_ns);
        EXPECT_LE((step.angular - middle * Vector3d::UnitX()).norm(), 1e-12);
        EXPECT_LE((step.linear - (1.0 - 2.0 * middle) * Vector3d::UnitY()).norm(), 1e-12);
        t = step.t_end_ns;
      }
      t_state = t_frame;
    }
  }
}

TEST(InputBuffer, HoldsTheFirstSampleBeforeItAndTheLastAfterIt) {
  InputBuffer buffer;
  buffer.add(linear_sample(100 * kMs));
  buffer.add(linear_sample(105 * kMs));
  const std::vector<InputStep> before = buffer.steps(40 * kMs, 60 * kMs);
  ASSERT_EQ(before.size(), 1U);
  EXPECT_EQ(before[0].angular, linear_sample(100 * kMs).angular);
  const std::vector<InputStep> after = buffer.steps(105 * kMs, 109 * kMs);
  ASSERT_EQ(after.size(), 1U);
  EXPECT_EQ(after[0].angular, linear_sample(105 * kMs).angular);
  EXPECT_EQ(after[0].linear, linear_sample(105 * kMs).linear);
}

TEST(InputBuffer, AStepAcrossTheFirstSampleStopsThere) {
  InputBuffer buffer;
  buffer.add(linear_sample(100 * kMs));
  buffer.add(linear_sample(105 * kMs));
  const std::vector<InputStep> steps = buffer.steps(90 * kMs, 103 * kMs);
  expect_cover(steps, 90 * kMs, 103 * kMs);
  ASSERT_EQ(steps.size(), 2U);
  EXPECT_EQ(steps[0].angular, linear_sample(100 * kMs).angular);
  EXPECT_NEAR(steps[1].angular.x(), 0.1015, 1e-12);
}

TEST(InputBuffer, RemembersWhatTheNextStepNeeds) {
  InputBuffer whole = regular(200);
  InputBuffer pieces = regular(200);
  const std::vector<InputStep> expected = whole.steps(0, 180 * kMs);
  std::vector<InputStep> found;
  for (std::int64_t t = 0; t < 180; t += 20) {
    const std::vector<InputStep> part = pieces.steps(t * kMs, (t + 20) * kMs);
    pieces.forget_before((t + 20) * kMs);
    found.insert(found.end(), part.begin(), part.end());
  }
  EXPECT_LE(pieces.size(), 6U);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t k = 0; k < found.size(); ++k) {
    EXPECT_EQ(found[k].t_end_ns, expected[k].t_end_ns);
    EXPECT_LE((found[k].angular - expected[k].angular).norm(), 1e-15);
  }
}

TEST(InputBuffer, RegularSamplesLeaveNoGap) {
  InputBuffer buffer = regular(100);
  EXPECT_DOUBLE_EQ(buffer.usual_interval_s(), 0.005);
  for (const InputStep& step : buffer.steps(1 * kMs, 99 * kMs)) {
    EXPECT_EQ(step.gap, 1.0);
  }
}

TEST(InputBuffer, DroppedSamplesShowAsAGapOfTheirLength) {
  InputBuffer buffer;
  for (std::int64_t t = 0; t <= 200; t += 5) {
    if (t < 100 || t > 115) {
      buffer.add(linear_sample(t * kMs));  // 100, 105, 110, 115 are lost: 25 ms from 95 to 120
    }
  }
  for (const InputStep& step : buffer.steps(0, 200 * kMs)) {
    if (step.t_end_ns == 120 * kMs) {
      EXPECT_NEAR(step.gap, 5.0, 1e-9);
      EXPECT_GT(step.angular_unknown.density, 0.0);
    } else {
      EXPECT_EQ(step.gap, 1.0) << step.t_end_ns;
    }
  }
}

TEST(InputBuffer, EachPartOfAGapCutByFramesKnowsTheWholeGap) {
  InputBuffer buffer;
  for (const std::int64_t t : {0, 5, 10, 60, 65}) {
    buffer.add(linear_sample(t * kMs));
  }
  EXPECT_NEAR(buffer.steps(10 * kMs, 30 * kMs).front().gap, 10.0, 1e-9);
  EXPECT_NEAR(buffer.steps(30 * kMs, 60 * kMs).front().gap, 10.0, 1e-9);
}

TEST(InputBuffer, SilenceAfterTheLastSampleIsAGap) {
  InputBuffer buffer = regular(20);
  EXPECT_EQ(buffer.steps(20 * kMs, 26 * kMs).front().gap, 1.0);
  EXPECT_NEAR(buffer.steps(26 * kMs, 70 * kMs).front().gap, 10.0, 1e-9);
}

TEST(InputBuffer, RefusesTimeThatDoesNotIncrease) {
  InputBuffer buffer = regular(20);
  EXPECT_THROW(buffer.add(linear_sample(20 * kMs)), std::invalid_argument);
  EXPECT_THROW(buffer.add(linear_sample(10 * kMs)), std::invalid_argument);
  EXPECT_NO_THROW(buffer.add(linear_sample(21 * kMs)));
}

TEST(InputBuffer, RefusesValuesThatAreNotFinite) {
  InputBuffer buffer;
  InputSample sample = linear_sample(0);
  sample.angular.y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(buffer.add(sample), std::invalid_argument);
  sample = linear_sample(0);
  sample.linear.z() = std::numeric_limits<double>::infinity();
  EXPECT_THROW(buffer.add(sample), std::invalid_argument);
  EXPECT_TRUE(buffer.empty());
}

}  // namespace
}  // namespace limber
