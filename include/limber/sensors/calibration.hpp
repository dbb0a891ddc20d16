// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>

#include "limber/core/pose.hpp"
#include "limber/sensors/camera.hpp"

namespace limber {

/// theta, the rig: (ax, ay, az [rad], tx, ty, tz [m]) with X_cam1 = R_s X_cam0 + t_s,
/// R_s = Rz(az) Ry(ay) Rx(ax), t_s = (tx, ty, tz). Paper, Eqs. (25)-(27) as corrected: t_s = (-2, 0, 0)
/// is a right camera that stands 2 m to the right.
using RigParameters = Eigen::Matrix<double, 6, 1>;

[[nodiscard]] Pose pose_from_rig(const RigParameters& theta);  ///< T_cam1_cam0
/// The inverse of pose_from_rig.
[[nodiscard]] RigParameters rig_from_pose(const Pose& T_cam1_cam0);

/// Where the body frame of the navigation state sits.
enum class BodyFrame {
  kImu,              ///< T_body_cam0 is known and does not depend on theta
  kCam0,             ///< the left camera (the paper)
  kMiddleOfBaseline  ///< halfway between the cameras, in position and attitude: both depend on theta
};

/// What an estimator may assume about a stereo rig. Never the truth.
struct StereoCalibration {
  /// left and right camera
  Camera cam0, cam1;
  /// assumed [rad, m]
  RigParameters theta = RigParameters::Zero();
  /// what the state's pose is the pose of
  BodyFrame body = BodyFrame::kImu;
  Pose T_body_cam0;  ///< used for kImu; identity for kCam0, derived from theta for kMiddleOfBaseline
  /// How much later than its stamp an image of cam0, cam1 was taken [s], by the clock of IMU or odometry.
  std::array<double, 2> time_offset_s{};
  /// How long cam0, cam1 take from the first row of an image to its last [s]: row v is exposed at stamp +
  /// (v / height - 1/2) of it. 0: all rows at once; negative: from the last row to the first.
  std::array<double, 2> readout_time_s{};

  /// Distance between the camera centres [m].
  [[nodiscard]] double baseline() const;
  /// member by member
  bool operator==(const StereoCalibration&) const = default;
};

/// @throws std::invalid_argument, which names the value, for what no rig has: a number that is not finite, a
/// focal length or baseline that is not positive, a T_body_cam0 (if it is used) that does not rotate
void check_calibration(const StereoCalibration& calibration);

/// The longest that an image may take from its first row to its last [s].
inline constexpr double kLongestReadout = 0.1;

/// How much later than its stamp row v of a camera is exposed [s].
[[nodiscard]] inline double row_delay(const Camera& camera, double readout_time_s, double v) {
  return (v / camera.height - 0.5) * readout_time_s;
}

/// One plausible error of theta: 0.1 deg, and 5 % of the baseline [rad, m].
[[nodiscard]] RigParameters plausible_error(double baseline);

/// Plausible errors that a rig may be off by where nothing is known of it, one standard deviation: 1 deg,
/// 50 % of the baseline.
inline constexpr double kWidestErrors = 10.0;

/// IMU noise: continuous densities, as in EuRoC's imu0/sensor.yaml.
struct ImuNoise {
  double gyro_density = 1.7e-4;   ///< [rad/s/sqrt(Hz)]
  double gyro_walk = 2.0e-5;      ///< [rad/s^2/sqrt(Hz)]
  double accel_density = 2.0e-3;  ///< [m/s^2/sqrt(Hz)]
  double accel_walk = 3.0e-3;     ///< [m/s^3/sqrt(Hz)]

  /// member by member
  bool operator==(const ImuNoise&) const = default;
};

/// How much noisier an IMU is than stated: standard deviations of its white noise over the stated ones [-].
struct ImuNoiseFactors {
  double gyro = 1.0;   ///< of gyro_density
  double accel = 1.0;  ///< of accel_density
};

/// Odometry noise per sample: standard deviations of body velocity [m/s] and rate [rad/s].
struct OdometryNoise {
  /// x, y, z of the body [m/s]
  Eigen::Vector3d sigma_v = Eigen::Vector3d::Constant(0.1);
  /// x, y, z of the body [rad/s]
  Eigen::Vector3d sigma_omega = Eigen::Vector3d::Constant(0.02);
};

/// Standard deviations of (u0, v0, u1, v1) [px].
using PixelNoise = Eigen::Vector4d;

/// Of the four [px].
[[nodiscard]] inline double root_mean_square(const PixelNoise& sigma) { return 0.5 * sigma.norm(); }

}  // namespace limber
