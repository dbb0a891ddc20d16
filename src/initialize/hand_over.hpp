// SPDX-License-Identifier: MIT
#pragma once

#include "window_problem.hpp"

namespace limber::detail {

/// @brief The body at the window's last frame and the points as its left camera sees them, with their joint
/// covariance.
/// @param frames  covariance of the frames' errors
[[nodiscard]] InitialState hand_over(const WindowModel& model, const WindowState& state,
                                     const WindowNormal& normal, const Eigen::MatrixXd& frames);

}  // namespace limber::detail
