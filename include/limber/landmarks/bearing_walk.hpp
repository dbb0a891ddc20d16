// SPDX-License-Identifier: MIT
#pragma once

#include "limber/measure/rig.hpp"
#include "limber/sensors/samples.hpp"
#include "limber/state/estimate.hpp"

namespace limber {

/// How bearings of landmarks that were seen for long walk.
struct BearingWalk {
  double sigma = 0.0;  ///< from one frame to the next [rad]
  double after = 0.0;  ///< frames that have told of a landmark
};

/// @brief Lets landmarks of many sightings walk across the rays of the left camera, which sees them in
/// `frame`; before the frame's update. Where a part of the pixels' errors lasts, they would else be known
/// better than this part lets know, and what is left of it, the same in every frame, would move everything
/// else instead, ever further. Their distances stay as they are.
/// @param[in,out] estimate  what is passive in it stays as it is
void walk_bearings(Estimate& estimate, const StereoFrame& frame, const MountedCamera& cam0,
                   const BearingWalk& walk);

}  // namespace limber
