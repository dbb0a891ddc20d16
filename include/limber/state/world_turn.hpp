// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>

namespace limber {

/// A correction of a world vector while the world turns, to second order: that of the right-invariant error.
/// @param dx    [m], [m/s]: what the error state says
/// @param turn  [rad], in world axes
[[nodiscard]] inline Eigen::Vector3d turned_with_world(const Eigen::Vector3d& dx,
                                                       const Eigen::Vector3d& turn) {
  return dx + 0.5 * turn.cross(dx);
}

}  // namespace limber
