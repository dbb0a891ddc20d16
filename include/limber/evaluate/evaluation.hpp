// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "limber/evaluate/alignment.hpp"
#include "limber/evaluate/association.hpp"
#include "limber/evaluate/trajectory_error.hpp"

namespace limber {

/// Absolute errors after one kind of alignment; without errors where the alignment is not determined.
struct AlignedErrors {
  /// what was taken out
  Alignment alignment;
  /// position [m] and attitude [rad]; nothing unless it is determined
  std::optional<PoseErrorStatistics> errors;
};

/// Distance of the relative errors over distance.
struct RelativeErrorSettings {
  double distance = 100.0;          ///< [m] along the estimated path
  double relative_tolerance = 0.1;  ///< [-]
};

/// Everything that is said of a trajectory against its truth.
struct TrajectoryEvaluation {
  std::size_t poses = 0;              ///< matched
  double duration = 0.0;              ///< first to last matched pose [s]
  double path_length = 0.0;           ///< of the truth [m]
  double path_length_estimate = 0.0;  ///< [m]
  /// by what is taken out: nothing, position and yaw of the first pose, a rigid transform, one with a scale
  AlignedErrors none, first_pose, se3, sim3;
  std::optional<PoseErrorStatistics> relative_1_frame;   ///< nothing with a single pose
  std::optional<PoseErrorStatistics> relative_distance;  ///< nothing on a path shorter than the distance
};

/// @throws std::invalid_argument if there are no poses, or the settings are not positive
[[nodiscard]] TrajectoryEvaluation evaluate_trajectory(std::span<const MatchedPose> poses,
                                                       const RelativeErrorSettings& settings = {});

}  // namespace limber
