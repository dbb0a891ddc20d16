// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <span>

#include "limber/predict/input_buffer.hpp"
#include "limber/predict/motion.hpp"
#include "limber/sensors/calibration.hpp"
#include "limber/state/state.hpp"

/// @file
/// What the inputs between two frames say of the two states: IMU (preintegrated), odometry, constant
/// velocity.
namespace limber {

/// Noise of whatever drives the prediction; the motion model says which is used.
struct MotionNoise {
  /// kImu: continuous densities
  ImuNoise imu;
  OdometryNoise odometry;  ///< per sample
  /// kConstantVelocity: continuous densities
  ConstantVelocityNoise constant_velocity;
};

/// @brief The inputs between two frames, summed up once: the motion from a body at rest at the origin of a
/// world without gravity, in the axes of the first body frame. [Forster2017], Sec. VI, by the filter's own
/// prediction.
struct MotionBetween {
  /// what summed it up
  MotionModel motion = MotionModel::kImu;
  double dt = 0.0;        ///< [s]
  NavigationState delta;  ///< its biases are those that it was summed up with
  Eigen::MatrixXd Phi;    ///< body_size(): how delta depends on where it began, biases above all
  Eigen::MatrixXd Q;      ///< body_size(): covariance of the error of delta
};

/// @param inputs             steps that fill the time between the frames (InputBuffer::steps); not read for
/// kConstantVelocity
/// @param from               IMU: biases to sum up with; its attitude says what an accelerometer shows at
/// rest, where samples are missing
/// @param sample_interval_s  odometry: usual time between samples
/// @param gravity            [m/s^2]; IMU
[[nodiscard]] MotionBetween motion_between(MotionModel motion, double dt, std::span<const InputStep> inputs,
                                           const NavigationState& from, const MotionNoise& noise,
                                           double sample_interval_s, double gravity);

/// How far two states are from what the inputs between them say: error = true minus predicted, in the order
/// of StateLayout, with the covariance MotionBetween::Q. IMU, odometry: position and velocity in the axes of
/// the first body frame; constant velocity: of the world.
struct MotionError {
  Eigen::VectorXd error;         ///< body_size()
  Eigen::MatrixXd J_from, J_to;  ///< body_size()²: of the error states of both
};

/// @param gravity  [m/s^2], along −z of the world; IMU only
[[nodiscard]] MotionError motion_error(const MotionBetween& between, const NavigationState& from,
                                       const NavigationState& to, double gravity);

}  // namespace limber
