// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "limber/core/pose.hpp"

/// @file
/// A point from the motion of the left camera alone.
namespace limber::detail {

/// The left camera's sight of a point.
struct LeftView {
  Pose T_world_cam0;   ///< where it was
  Eigen::Vector3d d0;  ///< z = 1
};

/// A point, and how well it is known.
struct LeftPoint {
  Eigen::Vector3d in_world;    ///< [m]
  Eigen::Matrix3d covariance;  ///< [m^2] per rad^2 of the bearings' noise
};

/// Least squares of the pixels, without views that are far off beside the others (mismatches); nothing of
/// fewer than four views, behind a camera, or of what has moved.
[[nodiscard]] std::optional<LeftPoint> triangulate(std::vector<LeftView> views, double focal_px);

}  // namespace limber::detail
