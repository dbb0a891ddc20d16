// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

namespace limber::detail {

/// @brief Ends matches in the right image that leapt to something else.
///
/// From one frame to the next the parallax between the cameras changes as the depth does, which is by a
/// fraction. Where that of more than half of the points of two frames grows or shrinks by more than a factor
/// of 1.5 within half a second, the front end has lost the right image; the points that leapt go on in the
/// left one alone.
/// @return number of points that lost their match
std::size_t end_leaping_matches(std::vector<StereoFrame>& frames, const StereoCalibration& calibration);

}  // namespace limber::detail
