// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>

#include "limber/core/pose.hpp"

namespace limber {

/// What a filter that trusts the calibration makes of the same recording, against one that it cannot lead
/// astray. Neither is the truth: what both get wrong alike does not show.
struct PoseLoss {
  double path_m = 0.0;           ///< of the one that is not led astray
  double scale = 1.0;            ///< of the trusting one's path: 1.02 is 2 % too long
  double drift_per_100_m = 0.0;  ///< difference of the last positions, first poses aligned [m]
  double turn_deg = 0.0;         ///< of the last attitudes
};

/// @return nothing with fewer than ten common poses, or a path of less than 1 m
[[nodiscard]] std::optional<PoseLoss> pose_loss(std::span<const StampedPose> trusting,
                                                std::span<const StampedPose> blind);

}  // namespace limber
