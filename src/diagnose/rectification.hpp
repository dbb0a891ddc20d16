// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>

#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

namespace limber::detail {

/// @brief Rectified images with the calibration of raw ones, or raw images with that of rectified ones, in
/// words.
///
/// Judged by the left camera alone, over pairs of frames 0.6 s apart: how far points lie from where the
/// camera's motion and their best depths put them. No rig that has moved changes that, a wrong lens does
/// where the camera turns or moves sideways; moving straight ahead hides it. (Left and right see a point
/// through nearly the same part of nearly the same lens: stereo hardly tells.) Only pairs count in which a
/// motion is found with either lens.
/// Depths to begin with are those of the calibration, or of the same rig `turned` as its epipolar lines say,
/// whichever leaves less: of a rig that has moved the former lead nowhere.
/// - Rectified: the calibration has distortion, and without it less than two thirds are left; or a
///   distortion that is estimated beside the motions over 0.2 s, whatever it starts from, is less than a
///   third of it, by 6 sigma and by Student's law for the seconds that tell, and leaves fewer squares.
/// - Raw: it has none, and a barrel distortion, estimated beside the motions over 0.2 s, is 6 sigma and more
///   than 0.1, and leaves fewer squares. Trackers drop points that a wrong lens bends most:
///   what is left lies in all of the pairs together, not in the size of one.
[[nodiscard]] std::optional<std::string> rectification_mistake(const StereoCalibration& calibration,
                                                               const RigParameters& turned,
                                                               std::span<const StereoFrame> frames);

}  // namespace limber::detail
