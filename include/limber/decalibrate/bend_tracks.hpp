// SPDX-License-Identifier: MIT
#pragma once

#include "limber/decalibrate/bent_rig.hpp"

namespace limber {

/// What bend_tracks could not move.
struct TrackBending {
  /// with the moved pixels and the true theta(t)
  Recording recording;
  std::size_t points = 0;      ///< right pixels that were moved
  std::size_t left_image = 0;  ///< right pixels that moved out of the image: now in the left one alone
  std::size_t without_depth =
      0;  ///< right pixels without partner, left out because the rig's translation bends
};

/// @brief A recording with matched points, as a rig that bends would have seen it: right pixels move.
/// The rotation turns the right bearing, errors and all. The translation moves it by the point's depth:
/// that of the true landmark and pose where the recording has both, else that of the pair itself (least
/// squares; behind the cameras: at infinity).
/// @throws std::invalid_argument if the recording has no matched points
[[nodiscard]] TrackBending bend_tracks(const Recording& recording, const BentRig& rig);

}  // namespace limber
