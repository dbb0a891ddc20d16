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
/// what all inverse depths have in common, 1ᵀ C⁻¹ 1; 0 of fewer than three points.
[[nodiscard]] double scale_information(const InitialState& state);

/// @brief Takes from the scale's information what noise alone can give, and widens the points' covariance by
/// as much along their common scale.
/// @note docs/derivations/start.md, "noise is no information"
void take_noise_from_scale(InitialState& state);

}  // namespace limber::detail
