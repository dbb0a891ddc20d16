// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "limber/core/pose.hpp"
#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

namespace limber {

/// @brief How the rig moved over a few frames, by its assumed calibration alone: points triangulated in the
/// first frame, then the pose of each later frame from their left pixels (Gauss-Newton, Huber loss). Metric
/// scale is that of the assumed calibration, with its error.
/// @param frames  the first is the reference
/// @return T_first_body(t) of the frames that share at least six points with the first one; the first is
/// identity.
///         Ends at the first frame that does not.
[[nodiscard]] std::vector<StampedPose> stereo_motion(std::span<const StereoFrame> frames,
                                                     const StereoCalibration& calibration);

}  // namespace limber
