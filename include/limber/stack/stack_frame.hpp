// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "limber/core/linear_measurement.hpp"
#include "limber/landmarks/landmark_initialization.hpp"
#include "limber/measure/rig.hpp"
#include "limber/sensors/samples.hpp"
#include "limber/state/estimate.hpp"

namespace limber {

/// Why a point of a frame was not used.
enum class RefusalReason : std::uint8_t {
  kGate,           ///< its projected residual was too large
  kNotProjectable  ///< its landmark does not project into the camera that saw it
};

/// One refused point.
struct Refusal {
  /// of the point
  std::int64_t track_id = 0;
  /// why it was not used
  RefusalReason reason = RefusalReason::kGate;
  double distance = 0.0;   ///< squared Mahalanobis distance [-]; kGate only
  double threshold = 0.0;  ///< what it exceeded [-]; kGate only
};

/// All usable rows of a frame, one group per point.
struct StackedFrame {
  /// of the groups' rows, in order
  LinearMeasurement measurement;
  std::vector<std::int64_t> track_ids;  ///< one per group
};

/// @brief Stacks the whole frame: every observed landmark of the map in every camera that saw it; of new
/// landmarks only the rows their initialisation left remaining. Points outside the map are passed over.
/// @param[in,out] refused  points that do not project are appended
[[nodiscard]] StackedFrame stack_frame(const Estimate& estimate, const StereoFrame& frame,
                                       const MountedRig& rig, const PixelNoise& sigma_px,
                                       const std::unordered_map<std::int64_t, RemainingRows>& new_landmarks,
                                       std::vector<Refusal>& refused);

}  // namespace limber
