// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"
#include "limber/state/state.hpp"

namespace limber {

/// Linearised step of the body's error state: dx' = Phi dx + w, w ~ N(0, Q). Both are body_size() wide.
struct Transition {
  /// n×n, of the body's error state
  Eigen::MatrixXd Phi;
  /// n×n, covariance of what the step adds
  Eigen::MatrixXd Q;
};

/// White noise of the constant-velocity model: continuous densities.
struct ConstantVelocityNoise {
  double acceleration_density = 0.5;          ///< [m/s^2/sqrt(Hz)]
  double angular_acceleration_density = 0.2;  ///< [rad/s^2/sqrt(Hz)]

  /// member by member
  bool operator==(const ConstantVelocityNoise&) const = default;
};

/// @brief Strapdown step over dt [s] with constant biases; advances `state` and returns the linearised step.
/// omega_imu and accel_imu are the (interpolated) means over the step. The attitude is advanced first by half
/// a step, acceleration is turned with that, then velocity and position: second order in dt. Gravity is (0,
/// 0, -gravity) in the world. The IMU is the body.
/// @note [Vivet2022], Eqs. (33)-(34); error equations [Sola2017], Sec. 5.3.
[[nodiscard]] Transition predict_imu(NavigationState& state, const Eigen::Vector3d& omega_imu,
                                     const Eigen::Vector3d& accel_imu, double dt, const ImuNoise& noise,
                                     double gravity);

/// @brief Constant velocity (world) and rate (body) over dt [s], driven by white accelerations.
[[nodiscard]] Transition predict_constant_velocity(NavigationState& state, double dt,
                                                   const ConstantVelocityNoise& noise);

/// @brief Body velocity and rate as inputs over dt [s], each with its noise per step: the position moves by
/// R_mid v dt, the attitude by omega dt. Also keeps v_world_body for the record.
[[nodiscard]] Transition predict_odometry(NavigationState& state, const Eigen::Vector3d& v_body,
                                          const Eigen::Vector3d& omega_body, double dt,
                                          const OdometryNoise& noise);

}  // namespace limber
