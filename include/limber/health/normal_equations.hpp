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
  /// of beta
  static constexpr int kSize = 7;
  static constexpr Eigen::Index kVergence = 1, kLens = 6;  ///< in beta
  static constexpr double kPrior =
      1e-2;  ///< information on beta before anything is seen: ten plausible errors
  /// over beta
  using Matrix = Eigen::Matrix<double, kSize, kSize>;
  /// over beta
  using Vector = Eigen::Matrix<double, kSize, 1>;
  /// sum of w J Jᵀ
  Matrix information = Matrix::Zero();
  /// sum of w J y
  Vector vector = Vector::Zero();

  /// Rows of both together.
  NormalEquations& operator+=(const NormalEquations& other);
  /// Sum of the rows' scores at beta.
  [[nodiscard]] Vector score(const Vector& beta) const;
};

}  // namespace limber
