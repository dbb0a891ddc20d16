// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace limber::frontend {

struct CornerOptions {
  int max_points = 120;      ///< taken and new ones together
  double min_distance = 20;  ///< [px] of a new point from every other one
  double min_strength = 15;  ///< smaller eigenvalue of the mean structure tensor [(grey level / px)^2]
  int border = 12;           ///< [px] that stay empty along the edges
};

/// @brief New corners [Shi1994] where points are missing, with sub-pixel refinement.
/// The image is divided into about max_points / 3 cells. Those that hold the fewest points are served first.
/// @param taken  points already there
/// @return at most max_points - taken.size() points
[[nodiscard]] std::vector<Eigen::Vector2d> new_corners(const cv::Mat& image,
                                                       const std::vector<Eigen::Vector2d>& taken,
                                                       const CornerOptions& options);

}  // namespace limber::frontend
