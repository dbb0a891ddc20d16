// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <optional>

#include "limber/health/calibration_watch.hpp"
#include "limber/health/health_monitor.hpp"
#include "limber/landmarks/landmark_initialization.hpp"
#include "limber/landmarks/map_management.hpp"
#include "limber/navigate/method.hpp"
#include "limber/predict/motion.hpp"
#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"
#include "limber/state/state.hpp"

namespace limber {

/// Table 1 of the paper, 'well estimated' (1e-6 rad^2 and 1 mm^2 per step of 10 ms), the translation in
/// proportion to the baseline (the paper's is 2 m): variance per second [rad^2/s, m^2/s].
[[nodiscard]] RigParameters default_theta_walk(double baseline);

/// Everything a navigator is told before it starts. Defaults are those of a small visual-inertial rig.
struct NavigatorOptions {
  /// what the filter makes of theta
  Method method = Method::kLcekf;
  ConstraintSet constraints;  ///< lcekf only
  /// Standard deviations of parameters that are estimated beside what the method does with theta; zero: not.
  /// Each walks by 1 % of it per sqrt(s). Not with theta for ekf-full, consider and adaptive: those have it.
  ParameterVector estimated = ParameterVector::Zero();
  /// Standard deviations of errors that are fresh in every frame (time-white), beside theta of soft; zero:
  /// none.
  ParameterVector softened = ParameterVector::Zero();
  /// what drives the prediction
  MotionModel motion = MotionModel::kImu;

  /// kImu: continuous densities
  ImuNoise imu_noise;
  /// imu_noise is the least: how much more there is is learned from what images say (LearnedImuNoise).
  bool learn_imu_noise = false;
  /// A start from the sensors finds how much later than taken an IMU's samples are stamped (to 0.25 s), and
  /// the filter corrects that until it is known (to 0.2 ms). Not where `dt0` is estimated.
  bool learn_imu_clock = false;
  OdometryNoise odometry_noise;  ///< per sample
  /// odometry_noise is but where to begin: it is learned from the samples (LearnedOdometryNoise).
  bool learn_odometry_noise = false;
  /// Standard deviation of a constant factor that odometry's speeds may be long or short by (the size of a
  /// wheel) [-]. It is considered and never corrected (Schmidt): lengths are known no better.
  double odometry_scale = 0.0;
  /// How the odometer's body stands against the camera is in doubt: turned by 0.5 deg about any axis, by
  /// another angle a third of a second later (docs/derivations/parameters.md). For odometry of which nobody
  /// stated how good it is. Not where the mount is estimated, softened or constrained, nor without a body.
  bool doubt_odometry_mount = false;
  /// kConstantVelocity: continuous densities
  ConstantVelocityNoise constant_velocity_noise;
  /// constant_velocity_noise is the least: how much more the body accelerates is learned from what images say
  /// (as LearnedImuNoise does of an IMU), and a start expects ten times as much.
  bool learn_motion_noise = false;
  /// u0, v0, u1, v1: white, per coordinate [px]
  PixelNoise sigma_px = PixelNoise::Constant(0.5);
  /// sigma_px is but where to begin: what has to be assumed is learned (LearnedPixelNoise).
  bool learn_pixel_noise = false;
  double gravity = 9.81;  ///< [m/s^2]
  /// Where only motion tells a common factor of all lengths, the covariance is carried along with it
  /// (docs/derivations/scale.md). Without, a filter of some hundred points that starts from a known state
  /// becomes too sure of its scale, as the paper's would. A start from the sensors, and odometry, always do.
  bool carries_scale = true;

  /// ekf-full, consider, soft: standard deviation of theta [rad, m]. Zero: one plausible error (0.1 deg, 5
  /// %).
  RigParameters theta_sigma = RigParameters::Zero();
  /// ekf-full: random walk of theta, variance per second [rad^2/s, m^2/s]. Nothing: default_theta_walk.
  std::optional<RigParameters> theta_walk;

  /// how points stand in the state
  LandmarkKind landmarks = LandmarkKind::kInverseDepth;
  LandmarkInitOptions landmark_init;  ///< mode and kind are set from method and landmarks
  /// its size, and what leaves it
  MapManagementOptions map;
  /// refuse points whose projected residual is too large
  bool gate = true;
  double gate_probability = 0.999;  ///< chance that a good point passes
  /// Watches the calibration; nothing: off. mono-left has nothing to watch.
  std::optional<HealthOptions> health = HealthOptions{};
  WatchOptions verdict{};  ///< if watched; false alarms as in `health`
};

}  // namespace limber
