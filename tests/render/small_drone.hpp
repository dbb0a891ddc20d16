// SPDX-License-Identifier: MIT
#pragma once

#include "limber/simulate/scenario.hpp"

namespace limber::testing {

/// A small rig with lenses that differ, which bends by two degrees.
inline Scenario small_drone(double seconds) {
  Scenario scenario;
  scenario.duration = seconds;
  scenario.trajectory = FigureEightTrajectory{.half_length = 3.0, .min_speed = 0.8, .max_speed = 1.2};
  scenario.rig.cam0 = {230.0, 229.0, 186.0, 121.0, 376, 240, RadialTangential{-0.28, 0.07, 2e-4, 1e-4}};
  scenario.rig.cam1 = {228.0, 231.0, 190.0, 118.0, 376, 240, RadialTangential{-0.27, 0.06, -1e-4, 2e-4}};
  scenario.rig.theta << 0.0, 0.0, 0.0, -0.15, 0.0, 0.0;
  scenario.rig.T_imu_cam0.R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  DecalibrationSignal bend;
  bend.amplitude << 0.02, -0.03, 0.035, 0.01, 0.0, 0.0;
  scenario.decalibration = {bend};
  return scenario;
}

}  // namespace limber::testing
