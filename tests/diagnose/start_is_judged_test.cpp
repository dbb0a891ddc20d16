// SPDX-License-Identifier: MIT
// The verdict begins with the frames that a start has used up.
#include <gtest/gtest.h>

#include <optional>
#include <variant>

#include "limber/core/angle.hpp"
#include "limber/diagnose/health_summary.hpp"
#include "limber/run/run_recording.hpp"
#include "limber/run/shared_starts.hpp"
#include "limber/simulate/simulator.hpp"
#include "shipped_scenario.hpp"

namespace limber {
namespace {

constexpr double kJolt = 5.3;  // [s]

/// A slow drone whose right camera is knocked by 0.3 deg while the start still waits for an acceleration.
Recording knocked_drone() {
  Scenario scenario = testing::shipped("drone_moving");
  auto& flight = std::get<RandomSplineTrajectory>(scenario.trajectory);
  flight.half_extent = {20.0, 20.0, 4.0};
  flight.max_speed = 2.0;
  scenario.stereo_rate = 10.0;
  scenario.duration = 16.0;
  DecalibrationSignal jolt;
  jolt.amplitude[0] = 0.3 / kToDegrees;
  jolt.shape = RampShape{kJolt, kJolt + 0.05};
  scenario.decalibration = {jolt};
  return simulate(scenario, 1);
}

TEST(StartIsJudged, AJoltWhileItWaitsIsSaidWithItsTime) {
  const Recording recording = knocked_drone();
  SharedStarts starts;
  for (const Method method : {Method::kLcekf, Method::kAdaptive}) {
    RunOptions options;
    options.method = method;
    const RunRecord record = run_recording(recording, options, matched_frames(recording), {}, &starts);
    ASSERT_GT(record.sensor_start->waited_s, kJolt);
    const std::optional<HealthSummary> found = summarize_health(record.frames);
    ASSERT_TRUE(found);
    ASSERT_EQ(found->past.size(), 1U) << to_string(method);
    EXPECT_NE(found->past[0].verdict, HealthVerdict::kDecalibrated);
    EXPECT_EQ(found->past[0].from_ns, recording.frames.front().t_ns);
    EXPECT_LE(found->seconds(found->past[0].to_ns), kJolt);
    EXPECT_GE(found->seconds(found->present.from_ns), kJolt);
    EXPECT_EQ(found->verdict, HealthVerdict::kDecalibrated);
    EXPECT_EQ(found->present.named, 0U);
    EXPECT_NEAR(found->present.estimate.delta[0], 0.3 / kToDegrees, 0.02 / kToDegrees);
  }
}

}  // namespace
}  // namespace limber
