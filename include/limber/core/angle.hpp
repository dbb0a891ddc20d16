// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace limber {

inline constexpr double kToDegrees = 180.0 / std::numbers::pi;  ///< of an angle in radians

/// Of two directions of any length, in any axes [rad], 0 to pi.
[[nodiscard]] inline double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace limber
