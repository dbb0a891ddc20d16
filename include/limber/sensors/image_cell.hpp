// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "limber/sensors/calibration.hpp"

namespace limber {

/// @brief Number of the part of an image, a fifth of its width by a quarter of its height, that a pixel lies
/// in. What the model of a lens leaves is much the same within one, and hardly related between them: it goes
/// with the lens, however many pixels are behind that.
[[nodiscard]] inline int image_cell(const Camera& camera, const Eigen::Vector2d& uv) {
  constexpr double kColumns = 5.0, kRows = 4.0;
  constexpr int kRowLength = 1 << 16;
  return static_cast<int>(std::floor(kColumns * uv.x() / std::max(camera.width, 1))) +
         kRowLength * static_cast<int>(std::floor(kRows * uv.y() / std::max(camera.height, 1)));
}

/// What the points of one image cell say of theta in a least-squares problem.
struct CellScore {
  /// Minus the gradient of half their squared residuals by theta, after all else is eliminated [1/rad, 1/m]
  RigParameters pull = RigParameters::Zero();
  /// Their curvature, after the points alone are eliminated [1/rad, 1/m, squared].
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
};

}  // namespace limber
