// SPDX-License-Identifier: MIT
#pragma once

#include <array>
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
/// @param vergence  vergence_axis() of the rig
/// @return a size of zero with an infinite upper end where there are less than three blocks
[[nodiscard]] RigMovement movement_of(const std::vector<FrameHalves>& blocks, Eigen::Index vergence);

/// How far that changes depths.
struct DepthMovement {
  SizeInterval share;     ///< of a depth straight ahead (root mean square)
  Eigen::Index axis = 1;  ///< ax ... tz: what alone explains most of it
};

/// The directions of theta, in plausible errors, that change a depth straight ahead: of its angles
/// (vergence), and of its baseline (the length). Unit vectors.
[[nodiscard]] std::array<RigParameters, 2> depth_ways(const RigParameters& theta);

/// @brief From the disparities of frames: as if the cameras turned, or as if the baseline's length changed,
/// whichever explains more; where neither certainly does (95 %), the interval holds both, and it is said to
/// be a turn: cameras turn in their mounts, what is between them hardly gets longer.
/// @param blocks     half a second each; they count as independent
/// @param theta      the assumed rig
/// @param baselines  depth at which the share is meant
/// @return a size of zero with an infinite upper end where there are less than three blocks
[[nodiscard]] DepthMovement depth_movement_of(const std::vector<DepthHalves>& blocks,
                                              const RigParameters& theta, double baselines);

}  // namespace limber
