// SPDX-License-Identifier: MIT
#pragma once

#include "window_problem.hpp"

namespace limber::detail {

/// @brief The body at the window's last frame and the points as its left camera sees them, with their joint
/// covariance.
/// @param frames  covariance of the frames' errors
[[nodiscard]] InitialState hand_over(const WindowModel& model, const WindowState& state,
                                     const WindowNormal& normal, const Eigen::MatrixXd& frames);

/// @brief What tells of the scale of a map that nothing but motion gives one: 1/sigma^2 of the logarithm of
/// what all inverse depths have in common, 1ᵀ C⁻¹ 1; 0 of fewer than three points. As hand_over() would give
/// it, at a fraction of its cost.
[[nodiscard]] double scale_information(const WindowModel& model, const WindowState& state,
                                       const WindowNormal& normal, const Eigen::MatrixXd& frames);

/// @brief What is left of the scale's information without what noise alone can give.
/// @note docs/derivations/start.md, "noise is no information"
[[nodiscard]] double without_noise(double scale_information);

/// Widens the points' covariance along their common scale until that is known so well.
void take_noise_from_scale(InitialState& state);

}  // namespace limber::detail
