// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "limber/core/pose.hpp"
#include "limber/measure/rig.hpp"
#include "limber/sensors/samples.hpp"
#include "limber/state/estimate.hpp"

namespace limber::detail {

/// @brief Where a frame's stereo points, triangulated, put the body in the map: whatever pose the estimate
/// has, and about as well as depths are known. Points that most others contradict are left out, and a common
/// factor of all depths does not matter.
/// @return nothing of fewer than ten points
[[nodiscard]] std::optional<Pose> body_by_stereo(const Estimate& map, const StereoFrame& frame,
                                                 const MountedRig& rig);

}  // namespace limber::detail
