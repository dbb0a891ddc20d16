// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

namespace limber {

/// Directions of D whose scaled, whitened singular value is below this move no pixel: they are left alone.
inline constexpr double kWeakDirection = 1e-3;

/// @brief Basis of the column space of D without its weak directions: D times the right singular vectors
/// whose singular value is at least kWeakDirection. D: m×c, whitened and scaled; result m×rank, full column
/// rank.
[[nodiscard]] Eigen::MatrixXd strong_directions(const Eigen::Ref<const Eigen::MatrixXd>& D);

/// @brief An orthogonal change of the rows of a measurement, Q = H_1 ... H_c (Householder), such that Qᵀ D C
/// has non-zeros only in its first rank rows of the rows it touches. Those are ordered last; what stands
/// before them is Nᵀ times the measurement, N a basis of the left null space of D C.
class NullSpaceProjection {
 public:
  /// @param D  m×c, whitened (unit noise) and scaled so that a column of one means one plausible error;
  ///           any rank. Rows of zeros are never touched.
  explicit NullSpaceProjection(const Eigen::Ref<const Eigen::MatrixXd>& D);

  [[nodiscard]] Eigen::Index rank() const { return rank_; }

  /// x := Π Qᵀ x for each column: the m − rank rows of Nᵀ x first, then the rank constrained ones.
  void apply_left(Eigen::Ref<Eigen::MatrixXd> x) const;

  /// X := X Q Πᵀ for each row of X.
  void apply_right(Eigen::Ref<Eigen::MatrixXd> x) const;

  /// S := Π Qᵀ S Q Πᵀ for symmetric S, both triangles given; afterwards only the lower one is valid.
  void apply_both(Eigen::Ref<Eigen::MatrixXd> S) const;

 private:
  void order_tail(Eigen::Index rows);

  Eigen::Index rank_ = 0;
  std::vector<Eigen::Index> touched_;  // rows where D is not zero, last first
  Eigen::MatrixXd V_;                  // |touched| × rank, Householder vectors, Q = I − V T Vᵀ
  Eigen::MatrixXd T_;                  // rank × rank, upper triangular (compact WY form)
  Eigen::Index tail_start_ = 0;        // Π leaves the rows before this one where they are
  std::vector<Eigen::Index>
      tail_order_;  // row tail_start_ + i of the result is row tail_start_ + tail_order_[i]
};

}  // namespace limber
