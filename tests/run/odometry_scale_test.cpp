// SPDX-License-Identifier: MIT
// Wheels that are a little larger than somebody thought.
#include <gtest/gtest.h>

#include <optional>

#include "limber/diagnose/run_summary.hpp"
#include "limber/run/run_recording.hpp"
#include "limber/simulate/simulator.hpp"
#include "run_and_summarize.hpp"
#include "shipped_scenario.hpp"

namespace limber {
namespace {

/// A drone with odometry in the place of an IMU, of which nobody states how good it is; true speeds are 1.5 %
/// larger.
Recording with_wrong_scale(std::uint64_t seed) {
  Scenario scenario = testing::shipped("drone_none", 15.0);
  scenario.use_imu = false;
  scenario.odometry = OdometryScenario{20.0, 0.03, 0.01};
  scenario.noise.stated = false;
  Recording recording = simulate(scenario, seed);
  for (OdometrySample& sample : recording.odometry) {
    sample.v_body /= 1.015;
  }
  return recording;
}

RunSummary summary(Method method, const Recording& recording, std::optional<double> doubted) {
  RunOptions options;
  options.method = method;
  options.odometry_scale = doubted;
  return testing::run_and_summarize(recording, options);
}

TEST(OdometryScale, OfWheelsIsInWhatLengthsAreKnownTo) {
  const Recording recording = with_wrong_scale(5);
  EXPECT_GT(summary(Method::kLcekf, recording, 0.0).anees_scale.value(), 10.0);
  for (const Method method : {Method::kEkf, Method::kLcekf}) {
    SCOPED_TRACE(to_string(method));
    const RunSummary doubted = summary(method, recording, {});
    EXPECT_LT(doubted.anees.value(), 2.0);
    EXPECT_LT(doubted.anees_scale.value(), 6.6);  // 99 % of chi-square of one
  }
}

}  // namespace
}  // namespace limber
