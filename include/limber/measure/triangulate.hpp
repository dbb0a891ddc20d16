// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <optional>

#include "limber/core/pose.hpp"

namespace limber {

/// @brief Inverse depth [1/m] along the bearing d0 (unit, cam0) that brings it closest to the bearing d1
/// (unit, cam1): least squares of d1 × (R d0 + rho t) = 0. May be negative (noise, or a wrong T_cam1_cam0).
/// @return nothing if d1 is parallel to the baseline
[[nodiscard]] std::optional<double> inverse_depth_along(const Eigen::Vector3d& d0, const Eigen::Vector3d& d1,
                                                        const Pose& T_cam1_cam0);

/// @brief Linear (DLT) triangulation: homogeneous point (X, w), unit norm, w >= 0, X / w in the cam0 frame
/// [m].
/// @note [Vivet2022], Eqs. (29)-(32): p_2D × p̂_2D = 0 in both cameras.
[[nodiscard]] Eigen::Vector4d triangulate_dlt(const Eigen::Vector3d& d0, const Eigen::Vector3d& d1,
                                              const Pose& T_cam1_cam0);

}  // namespace limber
