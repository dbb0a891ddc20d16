// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

namespace limber {

/// @brief An orthogonal change of rows, Q = H_1 ... H_k (Householder), such that Qᵀ A has non-zeros only in
/// its first k rows. What stands below them is Nᵀ times the measurement, N a basis of the left null space.
class NullSpaceProjection {
 public:
  /// @param A  m×k of full column rank
  explicit NullSpaceProjection(const Eigen::Ref<const Eigen::MatrixXd>& A);

  /// Directions of the constraint that the measurement can see.
  [[nodiscard]] Eigen::Index rank() const { return V_.cols(); }

  /// x := Qᵀ x for each column: the rank constrained rows first, then the m − rank rows of Nᵀ x.
  void apply_left(Eigen::Ref<Eigen::MatrixXd> x) const;

  /// X := X Q for each row of X.
  void apply_right(Eigen::Ref<Eigen::MatrixXd> x) const;

 private:
  Eigen::MatrixXd V_;  // m×k, Householder vectors, Q = I − V T Vᵀ
  Eigen::MatrixXd T_;  // k×k, upper triangular (compact WY form)
};

}  // namespace limber
