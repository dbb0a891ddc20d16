// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "limber/predict/input_buffer.hpp"
#include "limber/sensors/calibration.hpp"
#include "limber/state/state.hpp"

/// @file
/// What a step of the inputs is worth: noise of samples, of what is interpolated, forgotten or doubted.
namespace limber {

/// Variance densities beside what a step says of itself, per axis [unit^2 s].
struct MoreNoise {
  /// [rad²/s], and [m²/s^3] of an IMU or [m²/s] of odometry
  double angular = 0.0, linear = 0.0;
};

/// What an IMU's noise is beside the stated one.
[[nodiscard]] MoreNoise beside_stated(const ImuNoise& stated, const ImuNoiseFactors& factors);

/// The means over a step that predict_imu may use, and their noise.
struct ImuStep {
  /// angular rate [rad/s] and specific force [m/s^2], in the frame of the IMU
  Eigen::Vector3d omega, accel;
  /// densities with what the step adds to them
  ImuNoise noise;
};

/// @param body  attitude in the world, to know what an accelerometer shows at rest, and biases
[[nodiscard]] ImuStep imu_step(const InputStep& step, const NavigationState& body, const ImuNoise& noise,
                               double gravity, const MoreNoise& more = {});

/// Per-sample noise as it acts over the step: white, so that its variance goes with the usual sample interval
/// [s] (0: not known) over dt.
[[nodiscard]] OdometryNoise odometry_step_noise(const InputStep& step, const OdometryNoise& noise,
                                                double usual_interval_s, const MoreNoise& more = {});

}  // namespace limber
