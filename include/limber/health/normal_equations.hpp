// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

namespace limber {

/// @brief Weighted normal equations, information beta = vector.
///
/// beta: the rig's error in plausible errors (0.1 deg, 5 % of the baseline), and seventh what vergence would
/// do across the epipolar lines (x y). That is what a wrong lens does too, so that it says nothing of ay,
/// which shows in depths alone.
struct NormalEquations {
  static constexpr int kSize = 7;
  static constexpr Eigen::Index kVergence = 1, kLens = 6;  ///< in beta
  static constexpr double kPrior =
      1e-2;  ///< information on beta before anything is seen: ten plausible errors
  using Matrix = Eigen::Matrix<double, kSize, kSize>;
  using Vector = Eigen::Matrix<double, kSize, 1>;
  Matrix information = Matrix::Zero();
  Vector vector = Vector::Zero();

  NormalEquations& operator+=(const NormalEquations& other);
  /// Sum of the rows' scores at beta.
  [[nodiscard]] Vector score(const Vector& beta) const;
};

}  // namespace limber
