// SPDX-License-Identifier: MIT
#pragma once

#include "limber/simulate/simulator.hpp"

namespace limber::testing {

/// Two seconds of the paper's case (ii), with odometry beside the IMU: 41 frames.
inline Scenario short_scenario() {
  Scenario scenario;
  scenario.name = "short";
  scenario.duration = 2.0;
  scenario.odometry = OdometryScenario{};
  scenario.decalibration = {{paper_decalibration(), ConstantShape{}}};
  return scenario;
}

inline Recording short_recording() { return simulate(short_scenario(), 1); }

inline Recording without_imu(Recording recording) {
  recording.imu.clear();
  recording.imu_noise.reset();
  return recording;
}

inline Recording vision_only(Recording recording) {
  recording = without_imu(std::move(recording));
  recording.odometry.clear();
  recording.odometry_noise.reset();
  return recording;
}

}  // namespace limber::testing
