// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "limber/measure/epipolar.hpp"

namespace limber::detail {

/// Fewer stereo points say nothing of a mistake.
inline constexpr std::size_t kEnoughStereo = 100;

/// Of all points that both cameras see.
struct StereoPairs {
  std::vector<StereoBearings> as_given;
  std::vector<StereoBearings> exchanged;  ///< of the same points, each pixel through the other camera's lens
};

/// Points that no lens has a ray for are left out.
[[nodiscard]] StereoPairs stereo_pairs(const StereoCalibration& calibration,
                                       std::span<const StereoFrame> frames);

/// The same rig with the right camera turned as the epipolar lines say.
[[nodiscard]] Pose turned_by_lines(Pose T_cam1_cam0, const std::vector<StereoBearings>& pairs,
                                   double focal_px);

/// @brief Cameras that are exchanged, a baseline or T_BS that is written the wrong way round, in words.
///
/// A stereo point agrees with a rig if it lies within 3 px of its epipolar line and in front of both cameras.
/// Far points agree whichever way the baseline points: those that agree with the calibration and with what
/// may have been meant tell nothing, and are left out. Of the others, a quarter of all points at least, less
/// than half agree with the calibration, and more than four of five would without the mistake. Cameras that
/// are exchanged have each other's lens, too.
///
/// A rig whose cameras have turned towards each other puts its points behind itself as well, as a baseline of
/// the wrong sign does. Epipolar lines know that turn, and are the same for both signs: where the turned rig
/// of the calibration agrees with as many points, nothing is said; but where pixels through the other
/// camera's lens fit the lines of the calibration twice as well as those of the turned rig fit them as they
/// are.
[[nodiscard]] std::optional<std::string> placement_mistake(const StereoCalibration& calibration,
                                                           const StereoPairs& pairs);

}  // namespace limber::detail
