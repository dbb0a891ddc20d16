// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <opencv2/core/types.hpp>
#include <optional>
#include <vector>

#include "frontend/pyramid.hpp"
#include "limber/frontend/stereo_tracker.hpp"

namespace limber::frontend {

/// @brief Finds points of the left image in the right one, in two dimensions.
/// The assumed calibration says no more than in which window to look.
class RightSearch {
 public:
  RightSearch(const StereoCalibration& assumed, const TrackerOptions& options);

  /// @param uv0    point in the left image [px]
  /// @param guess  where it may be in the right image [px], from its past; tried first
  /// @return its place in the right image, nothing if none is alike, or if two are
  [[nodiscard]] std::optional<Eigen::Vector2d> find(const Pyramid& left, const Pyramid& right,
                                                    const Eigen::Vector2d& uv0,
                                                    const std::optional<Eigen::Vector2d>& guess) const;

 private:
  [[nodiscard]] std::optional<cv::Rect2d> window(const Eigen::Vector2d& uv0) const;
  [[nodiscard]] std::vector<Eigen::Vector2d> candidates(const Pyramid& left, const Pyramid& right,
                                                        const Eigen::Vector2d& uv0) const;

  StereoCalibration assumed_;
  TrackerOptions options_;
};

}  // namespace limber::frontend
