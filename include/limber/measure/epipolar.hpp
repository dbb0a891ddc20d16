// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <optional>

#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

/// What stereo points say of a rig without anything else: no motion, no map.
namespace limber {

/// Undistorted directions of one point, scaled to z = 1.
struct StereoBearings {
  /// z = 1, in the axes of each camera
  Eigen::Vector3d cam0, cam1;
};

namespace detail {

/// @return nothing unless both cameras see the point within the range of their models
[[nodiscard]] inline std::optional<StereoBearings> bearings(const StereoCalibration& calibration,
                                                            const StereoObservation& o) {
  if (!o.in_cam0 || !o.in_cam1) {
    return std::nullopt;
  }
  const auto d0 = unproject(calibration.cam0, o.uv_cam0), d1 = unproject(calibration.cam1, o.uv_cam1);
  if (!d0 || !d1 || !(d0->z() > 0.0) || !(d1->z() > 0.0)) {
    return std::nullopt;
  }
  return StereoBearings{*d0 / d0->z(), *d1 / d1->z()};
}

/// Unit normal, in the right image, of the epipolar line of a left bearing, as (a, b, c) with a² + b² = 1.
[[nodiscard]] inline Eigen::Vector3d epipolar_line(const Eigen::Vector3d& cam0, const Pose& T_cam1_cam0) {
  const Eigen::Vector3d line = T_cam1_cam0.p.cross(T_cam1_cam0.R * cam0);
  return line / std::hypot(line.x(), line.y());
}

/// Signed distance of the right point from its epipolar line [1 = the focal length].
[[nodiscard]] inline double epipolar_error(const StereoBearings& pair, const Pose& T_cam1_cam0) {
  return epipolar_line(pair.cam0, T_cam1_cam0).dot(pair.cam1);
}

/// By a turn of the right camera, R becoming Exp(turn) R [rad], and by its translation.
using PoseSlope = Eigen::Matrix<double, 1, 6>;

/// Derivative of epipolar_error.
[[nodiscard]] PoseSlope epipolar_slope(const StereoBearings& pair, const Pose& T_cam1_cam0);

/// Turn and translation of T_cam1_cam0, as in PoseSlope, by changes of theta.
[[nodiscard]] Eigen::Matrix<double, 6, 6> pose_by_theta(const RigParameters& theta);

}  // namespace detail
}  // namespace limber
