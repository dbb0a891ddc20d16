// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>

#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"
#include "limber/state/estimate.hpp"

namespace limber {

/// @brief Bounds the points of a frame that an update has to work on: its cost grows with the cube of their
/// number, what they say hardly does once they cover the image.
///
/// Landmarks that the frame before used go on. Then come others that the estimate knows, then new points,
/// those first that have waited for longest; always where the image holds fewest (spread_points). What is
/// left out waits until a place is free.
class LandmarkBudget {
 public:
  /// @param assumed  sizes of the images
  /// @param most     points of a frame
  LandmarkBudget(const StereoCalibration& assumed, std::size_t most);

  /// @param frame        the next one in time
  /// @param previous_ns  time of the frame before
  [[nodiscard]] StereoFrame choose(StereoFrame frame, const Estimate& estimate, std::int64_t previous_ns);

 private:
  StereoCalibration assumed_;
  std::size_t most_;
  std::unordered_map<std::int64_t, int> waited_;  // frames in a row, of those that the last one left out
};

}  // namespace limber
