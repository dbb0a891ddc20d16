// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_set>

#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

namespace limber::detail {

/// Leaves the points of a frame beyond a number out; see FrameCleaner.
class PointThinner {
 public:
  PointThinner(const StereoCalibration& assumed, std::size_t most);

  /// @return number of points that were left out
  std::size_t thin(StereoFrame& frame);

 private:
  StereoCalibration assumed_;
  std::size_t most_;
  std::unordered_set<std::int64_t> kept_;  // of the last frame
};

}  // namespace limber::detail
