// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "limber/diagnose/run_summary.hpp"
#include "limber/run/smooth_recording.hpp"
#include "shipped_scenario.hpp"

namespace limber {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

/// The first guess has found it, and samples were smoothed as they are stamped: 0.12 m, ANEES 550.
TEST(SmoothedClock, IsTheOneThatTheFirstGuessHasFound) {
  Recording recording = testing::realistic("drone_none", 8.0, 61);
  for (ImuSample& sample : recording.imu) {
    sample.t_ns -= 50'000'000;
  }
  SmoothOptions options;
  options.guess = Method::kLcekf;
  options.run.cleaning.max_points = 60;
  const RunRecord record = smooth_recording(recording, options, matched_frames(recording));
  EXPECT_THAT(record.notes, Contains(HasSubstr("later than they are stamped, by the images")));
  const RunSummary summary = summarize(recording, options.run, record);
  EXPECT_LT(summary.ate_se3_m.value(), 0.01);
  EXPECT_LT(summary.anees.value(), 2.5);
}

}  // namespace
}  // namespace limber
