// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <unordered_map>

#include "limber/navigate/frame_report.hpp"
#include "limber/sensors/samples.hpp"

namespace limber {

/// @brief Tracks of something that moves, which once was most of what a frame saw. Taken for new ones at
/// once, as other refused points are, they would correct the state in every second frame.
class MovingTracks {
 public:
  static constexpr double kLeftOut = 2.0;  ///< [s], after which they are asked again

  /// Takes those that are still left out out of the frame.
  void leave_out_of(StereoFrame& frame);

  /// Where the frame's gate refused most of its points as such: these.
  void note(const FrameReport& report);

 private:
  std::unordered_map<std::int64_t, std::int64_t> until_ns_;  // by track
};

}  // namespace limber
