// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "limber/core/so3.hpp"

namespace limber {

/// A correction of a world vector while the world turns: Jl(turn) dx, as the exponential of the
/// right-invariant error moves it [Barrau2015]. Where dx says nothing but that turn, the vector is turned by
/// it exactly.
/// @param dx    [m], [m/s]: what the error state says
/// @param turn  [rad], in world axes
[[nodiscard]] inline Eigen::Vector3d turned_with_world(const Eigen::Vector3d& dx,
                                                       const Eigen::Vector3d& turn) {
  return so3_right_jacobian(-turn) * dx;
}

}  // namespace limber
