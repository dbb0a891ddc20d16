// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "limber/core/dense.hpp"

namespace limber {

/// @file
/// Factors of matrices of any size, each compiled once, for the reason that dense.hpp gives. Where a matrix
/// must not be empty, or how it must be shaped, is asserted, not thrown.

/// A = L Lᵀ. Of A: n×n symmetric the lower triangle is read.
class Cholesky {
 public:
  /// Factors A, n×n; see succeeded().
  explicit Cholesky(Eigen::MatrixXd A);

  /// Whether A is positive definite; else nothing below means anything. NaN passes for positive.
  [[nodiscard]] bool succeeded() const { return succeeded_; }
  /// L in its lower triangle; above it what A had there.
  [[nodiscard]] const Eigen::MatrixXd& factor() const { return factor_; }
  /// L with zeros above.
  [[nodiscard]] Eigen::MatrixXd L() const;

  /// A⁻¹ B, a MatrixXd, or a VectorXd where B is a vector by its type.
  template <typename Derived>
  [[nodiscard]] auto solve(const Eigen::MatrixBase<Derived>& B) const {
    if constexpr (Derived::ColsAtCompileTime == 1) {
      return solved_vector(B);
    } else {
      return solved(B);
    }
  }
  /// A⁻¹: n×n.
  [[nodiscard]] Eigen::MatrixXd inverse() const;

 private:
  [[nodiscard]] Eigen::MatrixXd solved(Eigen::MatrixXd B) const;
  [[nodiscard]] Eigen::VectorXd solved_vector(Eigen::VectorXd b) const;

  Eigen::MatrixXd factor_;
  bool succeeded_;
};

/// A⁻¹ b, A: n×n symmetric and semidefinite, n > 0, by A = L D Lᵀ with pivots.
[[nodiscard]] Eigen::VectorXd solve_symmetric(const MatrixRef& A, const Eigen::VectorXd& b);

/// V with V Vᵀ = A, A: n×n symmetric and semidefinite, n > 0; eigenvalues that rounding made negative count
/// as zero. The lower triangle is read.
[[nodiscard]] Eigen::MatrixXd semidefinite_root(const MatrixRef& A);

/// A = V diag(values) Vᵀ, values ascending.
struct SymmetricEigen {
  Eigen::VectorXd values;   ///< n
  Eigen::MatrixXd vectors;  ///< V: n×n, orthonormal
};
/// Of A: n×n symmetric, n > 0, the lower triangle is read.
[[nodiscard]] SymmetricEigen symmetric_eigen(const MatrixRef& A);

/// A = Q R by Householder's reflections.
struct HouseholderQr {
  Eigen::MatrixXd
      factors;          ///< m×n: R in the upper triangle; below it the vectors v without their leading one
  Eigen::VectorXd tau;  ///< min(m, n): of the reflections I − tau v vᵀ

  /// The leading min(m, n) rows, zeros below the diagonal.
  [[nodiscard]] Eigen::MatrixXd R() const;
  /// m×m.
  [[nodiscard]] Eigen::MatrixXd Q() const;
  /// X := Qᵀ X, X: m×k.
  void apply_Qt(Eigen::Ref<Eigen::MatrixXd> X) const;
  /// x := Qᵀ x, x: m.
  void apply_Qt(Eigen::VectorXd& x) const;
};
/// A: m×n, not empty.
[[nodiscard]] HouseholderQr householder_qr(const MatrixRef& A);

/// A Pi = Q R, the diagonal of R as large as can be in each step.
struct PivotedQr {
  /// of A Pi
  HouseholderQr qr;
  /// n×n, turns columns into the order of the pivots
  Eigen::PermutationMatrix<Eigen::Dynamic> Pi;
  Eigen::Index rank = 0;  ///< up to rounding
  /// absolute value of R's first diagonal entry [unit of A]
  double largest_pivot = 0.0;

  /// The first rows of R Piᵀ: rows×n, rows <= min(m, n).
  [[nodiscard]] Eigen::MatrixXd turned_rows(Eigen::Index rows) const;
};
/// A: m×n, not empty.
[[nodiscard]] PivotedQr pivoted_qr(const MatrixRef& A);

/// Singular values, descending, and the vectors on the right.
struct RightSingular {
  Eigen::VectorXd values;  ///< min(m, n)
  Eigen::MatrixXd V;       ///< n×n
};
/// A: m×n, not empty.
[[nodiscard]] RightSingular right_singular(const MatrixRef& A);

/// A⁺ by a complete orthogonal decomposition, and A⁺ b.
struct PseudoInverse {
  Eigen::MatrixXd matrix;  ///< n×m
  Eigen::VectorXd x;       ///< n
};
/// A: m×n, not empty, b: m.
[[nodiscard]] PseudoInverse pseudo_inverse(const MatrixRef& A, const Eigen::VectorXd& b);
/// A⁺. A: m×n, not empty.
[[nodiscard]] Eigen::MatrixXd pseudo_inverse(const MatrixRef& A);

}  // namespace limber
