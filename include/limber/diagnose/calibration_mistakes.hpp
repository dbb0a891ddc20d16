// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

namespace limber {

/// @brief Mistakes that look like a rig that has moved, each as a sentence with numbers; none if none is
/// found.
///
/// - Lengths that are not in metres: cameras more than 10 m apart.
/// - Swapped cameras, T_BS of one or both cameras inverted, or a baseline of the wrong sign: of the stereo
///   points that do not agree either way (3 px from their epipolar line, in front of both cameras) less than
///   half agree with the calibration, and more than 80 % would without the mistake. Not where the cameras
///   have turned instead, as the epipolar lines say.
/// - Wrong resolution: more than 1 % of the pixels lie outside an image; a principal point further than a
///   fifth of the image from its centre; or all points of a camera within 60 % of both width and height.
/// - Rectified images with the calibration of raw ones, or the reverse: over 0.6 s the points of the left
///   camera fit a motion much better without distortion, or with one. Seen where the camera turns.
[[nodiscard]] std::vector<std::string> calibration_mistakes(const StereoCalibration& calibration,
                                                            std::span<const StereoFrame> frames);

/// The first two of these alone, or one of them: where the cameras stand.
[[nodiscard]] std::optional<std::string> placement_mistake(const StereoCalibration& calibration,
                                                           std::span<const StereoFrame> frames);

}  // namespace limber
