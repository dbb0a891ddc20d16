// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

namespace limber::detail {

/// How the body accelerated over half a second, by the cameras and by the accelerometer, less what it did on
/// average over a second before and behind: gravity and a bias are gone from both. In the axes that the gyro
/// had at first.
struct Acceleration {
  double t_s;              ///< since the first sample of the IMU
  Eigen::Vector3d camera;  ///< [m/s^2], of the scale that the assumed rig has
  /// What a column of M adds to the specific force M f, as a matrix by that column: x, y, z.
  Eigen::Matrix<double, 3, 9> by_mount;

  /// If the accelerometer's samples f were M f.
  [[nodiscard]] Eigen::Vector3d imu(const Eigen::Matrix3d& M) const { return by_mount * M.reshaped(); }
};

/// @brief Second differences of where the body was, by stereo with the assumed rig, against the specific
/// force over the same time by the same weights, turned by the gyro; one from every fifth of a second.
/// @param imu  at least two samples, in order of time
[[nodiscard]] std::vector<Acceleration> accelerations(const StereoCalibration& calibration,
                                                      std::span<const StereoFrame> frames,
                                                      std::span<const ImuSample> imu);

}  // namespace limber::detail
