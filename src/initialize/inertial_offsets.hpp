// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "limber/initialize/inertial_evidence.hpp"
#include "window_problem.hpp"

namespace limber::detail {

/// @brief The evidence of a window's solution. Bodies move by an offset so that the cameras stay where the
/// pixels want them, which leaves it to the inputs alone: their residuals' derivatives by the offsets, less
/// what the frames' errors can take up of them.
/// @param normal      at the solution
/// @param covariance  of the frames' errors there, see frame_covariance
[[nodiscard]] InertialEvidence evidence_of(const WindowModel& model, WindowState state,
                                           const WindowNormal& normal, const Eigen::MatrixXd& covariance);

}  // namespace limber::detail
