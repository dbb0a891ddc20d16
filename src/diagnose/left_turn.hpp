// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <optional>

#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

namespace limber::detail {

/// @brief How the body turned between two frames, by the left camera alone: two-view least squares with Huber
/// weights, in which the depth of each point is eliminated (so only the distance from its epipolar line
/// counts). Stereo only gives the depths to start from: errors of them, of the rig or constant along a track,
/// would make a motion sideways look like a turn.
/// @return the rotation vector of R_from_to [rad], in the body frame; nothing with fewer than ten points
/// that both frames see
[[nodiscard]] std::optional<Eigen::Vector3d> left_turn(const StereoCalibration& calibration,
                                                       const StereoFrame& from, const StereoFrame& to);

}  // namespace limber::detail
