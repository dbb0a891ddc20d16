// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "limber/update/evidence.hpp"

namespace limber {

/// @brief How large the part of the rig's error is that is fresh in every frame (vibration), axis by axis,
/// learned from what frames say about it. In plausible errors (0.1 deg, 5 % of the baseline).
///
/// Weighted method of moments: beta_hat² has the mean s² + c, c its known variance, and the weight of a
/// frame is the inverse of the square of both. The size in use is an upper confidence bound, so that it
/// starts wide and shrinks as far as the evidence goes.
/// @note docs/derivations/adaptive.md
class WhiteSize {
 public:
  /// by axis: ax, ay, az, tx, ty, tz
  using Vector6 = Eigen::Matrix<double, 6, 1>;

  /// Nothing is fresh: the size is zero and stays so until begin().
  [[nodiscard]] bool is_zero() const { return weight_.isZero(0.0); }

  /// Starts to learn: believes that the size is at least `sigma` [plausible errors].
  void begin(const Vector6& sigma);

  /// @param evidence  about beta of one frame, without the share of this size; six wide
  /// @param dt        [s] since the frame before
  void learn(const ParameterEvidence& evidence, double dt);

  /// Variance in use [plausible errors squared].
  [[nodiscard]] Vector6 variance() const;

 private:
  Vector6 weight_ = Vector6::Zero();  // sum of weights
  Vector6 sum_ = Vector6::Zero();     // of weighted beta_hat² − c
};

}  // namespace limber
