// SPDX-License-Identifier: MIT
#pragma once

namespace limber {

/// Standard deviations, per axis, of an initial state: what an estimator assumes, and what the errors of a
/// simulated start are drawn from.
struct InitialSigma {
  double position = 1e-3;    ///< [m]
  double attitude = 1e-4;    ///< [rad]
  double velocity = 0.01;    ///< [m/s]
  double bias_accel = 0.01;  ///< [m/s^2]
  double bias_gyro = 1e-3;   ///< [rad/s]
  double rate = 0.05;        ///< [rad/s], constant velocity only; nothing is drawn from it
};

}  // namespace limber
