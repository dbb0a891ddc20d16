// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "window_problem.hpp"

namespace limber::detail {

/// @brief Places to start the search from, the likeliest first: depths by the assumed rig; depths by the
/// left camera and the inertial samples; standing still with all points equally far.
/// @param frames  with steps and omega; states are ignored
/// @param raw     the same frames' points
[[nodiscard]] std::vector<WindowState> guesses(const WindowModel& model,
                                               const std::vector<WindowFrame>& frames,
                                               const std::vector<StereoFrame>& raw);

/// Points that two frames or more have seen, charts along their first bearing, inverse depths by the assumed
/// rig where it shows one (zero: it does not). 250 at most: those of the longest tracks, and of no frame
/// hardly any.
[[nodiscard]] std::vector<WindowPoint> points_of(const WindowModel& model,
                                                 const std::vector<StereoFrame>& raw);

/// Gives the points whose inverse depth is zero the one that fits best to the states by the left camera
/// alone.
void fill_depths_from_motion(const WindowModel& model, WindowState& state);

/// Inverse depth for points of which nothing is known [1/m].
inline constexpr double kSomeInverseDepth = 0.1;

/// The shortest rotation that makes `up_body` point up, then turned so that the left camera looks along x.
[[nodiscard]] Eigen::Matrix3d level_attitude(const WindowModel& model, const Eigen::Vector3d& up_body);

}  // namespace limber::detail
