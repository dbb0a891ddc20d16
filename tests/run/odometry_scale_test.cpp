// SPDX-License-Identifier: MIT
// Wheels that are a little larger than somebody thought, and turn a little more.
#include <gtest/gtest.h>

#include <cmath>

#include "limber/diagnose/run_summary.hpp"
#include "limber/run/run_recording.hpp"
#include "limber/simulate/scenario_file.hpp"
#include "limber/simulate/simulator.hpp"
#include "source_folder.hpp"

namespace limber {
namespace {

constexpr double kSpeed = 0.015, kTurn = -0.01;  // true over measured, minus one [-]

/// A drone with odometry in the place of an IMU, of which nobody states how good it is.
Recording with_wrong_scale(std::uint64_t seed) {
  Scenario scenario = read_scenario(testing::source_folder() / "scenarios" / "drone_none.yaml");
  scenario.duration = 15.0;
  scenario.use_imu = false;
  scenario.odometry = OdometryScenario{20.0, 0.03, 0.01};
  scenario.noise.stated = false;
  Recording recording = simulate(scenario, seed);
  for (OdometrySample& sample : recording.odometry) {
    sample.v_body /= 1.0 + kSpeed;
    sample.omega_body /= 1.0 + kTurn;
  }
  return recording;
}

struct Outcome {
  RunSummary summary;
  OdometryScale scale;
};

Outcome outcome(Method method, const Recording& recording, std::optional<double> doubted) {
  RunOptions options;
  options.method = method;
  options.odometry_scale = doubted;
  const RunRecord record = run_recording(recording, options, matched_frames(recording));
  return {summarize(recording, options, record), record.odometry_scale.value_or(OdometryScale{})};
}

TEST(OdometryScale, OfWheelsIsInWhatLengthsAreKnownTo) {
  const Recording recording = with_wrong_scale(5);
  EXPECT_GT(outcome(Method::kLcekf, recording, 0.0).summary.anees.value(), 5.0);
  for (const Method method : {Method::kEkf, Method::kLcekf}) {
    SCOPED_TRACE(to_string(method));
    const Outcome doubted = outcome(method, recording, {});
    EXPECT_LT(doubted.summary.anees.value(), 2.0);
    EXPECT_LT(doubted.summary.anees_scale.value(), 6.6);  // 99 % of chi-square of one
    EXPECT_DOUBLE_EQ(doubted.scale.error.x(), 0.0);
    EXPECT_NEAR(doubted.scale.sigma.x(), 0.01, 1e-4);
    EXPECT_NEAR(doubted.scale.error.y(), kTurn, 3.0 * doubted.scale.sigma.y());
    EXPECT_LT(doubted.scale.sigma.y(), 0.005);
  }
}

}  // namespace
}  // namespace limber
