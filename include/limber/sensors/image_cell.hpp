// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "limber/sensors/calibration.hpp"

namespace limber {

/// @brief Number of the part of an image, 150 x 120 px, that a pixel lies in. What the model of a lens leaves
/// is much the same within one, and hardly related between them.
[[nodiscard]] inline int image_cell(const Eigen::Vector2d& uv) {
  constexpr double kWidth_px = 150.0, kHeight_px = 120.0;
  constexpr int kColumns = 1 << 16;
  return static_cast<int>(std::floor(uv.x() / kWidth_px)) +
         kColumns * static_cast<int>(std::floor(uv.y() / kHeight_px));
}

/// What the points of one image cell say of theta in a least-squares problem.
struct CellScore {
  /// Minus the gradient of half their squared residuals by theta, after all else is eliminated [1/rad, 1/m]
  RigParameters pull = RigParameters::Zero();
  /// Their curvature, after the points alone are eliminated [1/rad, 1/m, squared].
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
};

}  // namespace limber
