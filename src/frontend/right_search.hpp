// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <opencv2/core/types.hpp>
#include <optional>
#include <vector>

#include "frontend/correlation.hpp"
#include "frontend/patch.hpp"
#include "frontend/pyramid.hpp"
#include "limber/frontend/stereo_tracker.hpp"

namespace limber::frontend {

/// The right image, and what all searches over its window share: made when the first one asks.
class SearchedImage {
 public:
  /// @param pyramid  has to stay
  explicit SearchedImage(const Pyramid& pyramid) : pyramid_(pyramid) {}
  [[nodiscard]] const Pyramid& pyramid() const { return pyramid_; }
  [[nodiscard]] const CorrelationImage& coarse();

 private:
  const Pyramid& pyramid_;
  std::optional<CorrelationImage> coarse_;
};

/// @brief Finds points of the left image in the right one, in two dimensions.
/// The assumed calibration says no more than in which window to look.
class RightSearch {
 public:
  RightSearch(const StereoCalibration& assumed, const TrackerOptions& options);

  /// @brief Looks at a place where the point should be within a few pixels.
  /// @param uv0    point in the left image [px]
  /// @param guess  where it may be in the right image [px], and what shape the left patch has there
  /// @return nothing if it is not there
  [[nodiscard]] std::optional<PatchFit> follow(const Pyramid& left, const Pyramid& right,
                                               const Eigen::Vector2d& uv0, const PatchFit& guess) const;

  /// @brief Looks all over the window.
  /// @return its place in the right image, nothing if none is alike, or if two are
  [[nodiscard]] std::optional<PatchFit> find(const Pyramid& left, SearchedImage& right,
                                             const Eigen::Vector2d& uv0) const;

 private:
  [[nodiscard]] std::optional<cv::Rect2d> window(const Eigen::Vector2d& uv0) const;
  [[nodiscard]] std::vector<Eigen::Vector2d> candidates(const Pyramid& left, SearchedImage& right,
                                                        const Eigen::Vector2d& uv0) const;
  [[nodiscard]] std::optional<PatchFit> verified(const PatchFit& there, const Pyramid& left,
                                                 const Pyramid& right, const Eigen::Vector2d& uv0) const;

  StereoCalibration assumed_;
  TrackerOptions options_;
  std::vector<Eigen::Matrix3d> turns_;  // by the search margin, up, down and to the sides
};

}  // namespace limber::frontend
