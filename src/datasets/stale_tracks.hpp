// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include "limber/sensors/samples.hpp"

namespace limber::detail {

/// @brief Ends tracks that were not tracked into a frame.
///
/// Where every point that a frame shares with the one before stands on the very same pixels, noise and all,
/// the front end has handed out the old positions once more; what it follows from there on is other texture.
/// Such points are taken out of that frame and get new ids afterwards. A log in which more than half of the
/// frames are so (a rig that stands still in a world without noise) is left as it is.
/// @return number of frames with such points
std::size_t cut_stale_tracks(std::vector<StereoFrame>& frames);

}  // namespace limber::detail
