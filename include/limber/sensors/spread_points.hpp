// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

namespace limber {

/// What comes first of the points of a frame: group by group, and in one field of the image by order; the
/// lower, the sooner.
struct PointRank {
  int group = 0;  ///< all of a lower one come before any of a higher one
  int order = 0;  ///< within a field of the image
};

/// @brief At most `most` points of a frame, spread over the image.
///
/// Group by group, one place after the other goes to the field of the image that holds fewest points; of 8 x
/// 6 fields of the left image, or of the right one for points that the left does not see.
/// @param ranks  one for each point of the frame
/// @return indices of the chosen points, ascending; all where there are no more than `most`
[[nodiscard]] std::vector<std::size_t> spread_points(const StereoFrame& frame,
                                                     const StereoCalibration& assumed, std::size_t most,
                                                     const std::vector<PointRank>& ranks);

/// The points of a frame at ascending indices.
[[nodiscard]] StereoFrame points_at(const StereoFrame& frame, const std::vector<std::size_t>& chosen);

}  // namespace limber
