// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

namespace limber {

/// @file
/// Products and triangular solves of matrices of any size, each compiled once: Eigen compiles them anew
/// wherever and for whatever expression they are written, at a second or more each. Shapes have to agree as
/// in the formula beside the name; that is asserted, as in Eigen, not thrown. Arguments are not copied if
/// they are matrices, blocks or columns of such. A transpose would be: say transposed(A) instead of
/// A.transpose(). No result may share memory with an argument. Matrices of fixed size and products with
/// vectors stay Eigen's.

/// A matrix of any size as an argument, not copied.
using MatrixRef = Eigen::Ref<const Eigen::MatrixXd>;

/// Aᵀ as an argument; A has to outlive the call.
struct Transposed {
  /// A itself, not transposed
  MatrixRef matrix;
};
/// Aᵀ.
[[nodiscard]] inline Transposed transposed(const MatrixRef& A) { return {A}; }

/// A B.
[[nodiscard]] Eigen::MatrixXd multiply(const MatrixRef& A, const MatrixRef& B);
/// Aᵀ B.
[[nodiscard]] Eigen::MatrixXd multiply(const Transposed& A, const MatrixRef& B);
/// A Bᵀ.
[[nodiscard]] Eigen::MatrixXd multiply(const MatrixRef& A, const Transposed& B);

/// A U Aᵀ, U: k×k.
[[nodiscard]] Eigen::MatrixXd congruence(const MatrixRef& A, const MatrixRef& U);
/// Aᵀ U A.
[[nodiscard]] Eigen::MatrixXd congruence(const Transposed& A, const MatrixRef& U);

/// C += alpha A B.
void add_product(Eigen::Ref<Eigen::MatrixXd> C, double alpha, const MatrixRef& A, const MatrixRef& B);
/// C += alpha Aᵀ B.
void add_product(Eigen::Ref<Eigen::MatrixXd> C, double alpha, const Transposed& A, const MatrixRef& B);
/// C += alpha A Bᵀ.
void add_product(Eigen::Ref<Eigen::MatrixXd> C, double alpha, const MatrixRef& A, const Transposed& B);

/// C += A Bᵀ in the lower triangle alone. C: n×n, A and B: n×k.
void add_lower_product(Eigen::Ref<Eigen::MatrixXd> C, const MatrixRef& A, const Transposed& B);

/// S += alpha W Wᵀ in the lower triangle alone. S: n×n, W: n×k.
void add_outer(Eigen::Ref<Eigen::MatrixXd> S, double alpha, const MatrixRef& W);

/// (A + Aᵀ) / 2, A: n×n.
[[nodiscard]] Eigen::MatrixXd symmetric_part(const MatrixRef& A);

/// X := L⁻¹ X. Of L: n×n the lower triangle is read.
void solve_lower(const MatrixRef& L, Eigen::Ref<Eigen::MatrixXd> X);
/// X := L⁻ᵀ X.
void solve_lower(const Transposed& L, Eigen::Ref<Eigen::MatrixXd> X);
/// x := L⁻¹ x.
void solve_lower(const MatrixRef& L, Eigen::VectorXd& x);
/// The same for a part of a vector.
void solve_lower(const MatrixRef& L, Eigen::VectorBlock<Eigen::VectorXd> x);

/// X := X L⁻¹.
void solve_lower_from_right(const MatrixRef& L, Eigen::Ref<Eigen::MatrixXd> X);
/// X := X L⁻ᵀ.
void solve_lower_from_right(const Transposed& L, Eigen::Ref<Eigen::MatrixXd> X);

}  // namespace limber
