// SPDX-License-Identifier: MIT
// A run whose calibration is wrong before it begins.
#include <gtest/gtest.h>

#include <algorithm>

#include "limber/core/angle.hpp"
#include "limber/core/time.hpp"
#include "limber/run/run_recording.hpp"
#include "limber/simulate/simulator.hpp"
#include "shipped_scenario.hpp"

namespace limber {
namespace {

constexpr double kFastest = 4.0;  // [m/s], the figure eight is flown at 2 to 3

/// A small drone whose rig is off by three degrees and a fifth of its baseline all the time.
Recording bent_drone() {
  Scenario scenario = testing::shipped("drone_none", 5.0);
  RigParameters error;
  error << 1.2 / kToDegrees, 3.0 / kToDegrees, 1.2 / kToDegrees, 0.024, 0.0024, 0.0024;
  scenario.decalibration = {{error, ConstantShape{}}};
  return simulate(scenario, 21);
}

/// The first frame after the start was updated by the wrong rig, and leapt by metres, before the alarm
/// looked.
TEST(WrongFromTheStart, AdaptiveNeverLeaps) {
  RunOptions options;
  options.method = Method::kAdaptive;
  const Recording recording = bent_drone();
  const RunRecord record = run_recording(recording, options, matched_frames(recording));
  double fastest = 0.0;
  for (std::size_t k = 1; k < record.trajectory.size(); ++k) {
    const TrajectoryRow &before = record.trajectory[k - 1], &now = record.trajectory[k];
    fastest = std::max(fastest, (now.T_world_body.p - before.T_world_body.p).norm() /
                                    seconds_between(before.t_ns, now.t_ns));
  }
  EXPECT_LT(fastest, kFastest);
}

}  // namespace
}  // namespace limber
