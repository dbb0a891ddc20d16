// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <vector>

#include "frontend/epipolar.hpp"
#include "frontend/right_search.hpp"
#include "limber/sensors/samples.hpp"

namespace limber::frontend {

/// @brief Right matches of left tracks, from frame to frame.
/// A match is looked for where it was, moved as its nearest neighbour's has moved since; where that fails,
/// all over the window. Tracks without match are asked again after 1, 2, 4 ... frames.
class RightMatcher {
 public:
  RightMatcher(const StereoCalibration& assumed, const TrackerOptions& options);

  /// Sets uv_cam1 and in_cam1 of the points whose right match can be trusted.
  void match(const Pyramid& left, const Pyramid& right, StereoFrame& frame);

 private:
  /// What is remembered of a track.
  struct Memory {
    Eigen::Vector2d offset = Eigen::Vector2d::Zero();     ///< uv_cam1 - uv_cam0 when last matched [px]
    Eigen::Matrix2d shape = Eigen::Matrix2d::Identity();  ///< of the left patch in the right image
    bool matched = false;                                 ///< in the frame before
    int failures = 0;                                     ///< in a row
    int wait = 0;                                         ///< frames until it is looked for again
  };
  /// By how much a match has moved against its left point.
  struct Change {
    Eigen::Vector2d uv_cam0, change;
  };

  [[nodiscard]] std::optional<PatchFit> look_for(const Pyramid& left, SearchedImage& right,
                                                 const Eigen::Vector2d& uv0, const Memory& memory,
                                                 const std::vector<Change>& changes) const;
  static void miss(Memory& memory);

  StereoCalibration assumed_;
  RightSearch search_;
  LeftRightConsensus consensus_;
  std::map<std::int64_t, Memory> memories_;  ///< by track_id
};

}  // namespace limber::frontend
