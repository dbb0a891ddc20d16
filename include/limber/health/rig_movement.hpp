// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "limber/health/frame_halves.hpp"
#include "limber/health/tolerance.hpp"

/// @file
/// How much a rig moves about its mean, from frame to frame: vibration, and what windows average.
namespace limber {

/// How far the rig of a frame is from the mean one.
struct RigMovement {
  SizeInterval px;        ///< what that moves points by, off their epipolar lines (root mean square)
  Eigen::Index axis = 0;  ///< ax ... tz: the largest part of it
};

/// @param blocks    half a second each; they count as independent
/// @param epipolar  as in BetaEstimate [px^2]
/// @return a size of zero with an infinite upper end where there are less than three blocks
[[nodiscard]] RigMovement movement_of(const std::vector<FrameHalves>& blocks,
                                      const NormalEquations::Matrix& epipolar);

}  // namespace limber
