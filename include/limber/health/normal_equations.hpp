// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "limber/sensors/calibration.hpp"

namespace limber {

/// @brief Weighted normal equations, information beta = vector.
///
/// beta: the rig's error in plausible errors (0.1 deg, 5 % of the baseline), and seventh what vergence would
/// do across the epipolar lines (x y). That is what a wrong lens does too, so that it says nothing of
/// vergence, which shows in depths alone.
struct NormalEquations {
  /// of beta
  static constexpr int kSize = 7;
  static constexpr Eigen::Index kLens = 6;  ///< in beta
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
  /// beta by these rows alone, which have to tell all of it.
  [[nodiscard]] Vector solution() const;
};

/// Which of ax and ay turns the cameras towards each other, and moves points along their epipolar lines: ay
/// of a pair side by side, ax of one above the other.
[[nodiscard]] Eigen::Index vergence_axis(const RigParameters& theta);

}  // namespace limber
