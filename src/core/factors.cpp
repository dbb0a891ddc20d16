// SPDX-License-Identifier: MIT
#include "limber/core/factors.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <utility>

namespace limber {

using Eigen::MatrixXd;
using Eigen::Ref;
using Eigen::VectorXd;

Cholesky::Cholesky(MatrixXd A) : factor_(std::move(A)) {
  Ref<MatrixXd> in_place(factor_);
  succeeded_ = Eigen::LLT<Ref<MatrixXd>>(in_place).info() == Eigen::Success;
}

MatrixXd Cholesky::L() const { return factor_.triangularView<Eigen::Lower>(); }

MatrixXd Cholesky::solved(MatrixXd B) const {
  solve_lower(factor_, B);
  if (B.size() > 0) {
    factor_.triangularView<Eigen::Lower>().transpose().solveInPlace(B);
  }
  return B;
}

VectorXd Cholesky::solved_vector(VectorXd b) const {
  solve_lower(factor_, b);
  if (b.size() > 0) {
    factor_.triangularView<Eigen::Lower>().transpose().solveInPlace(b);
  }
  return b;
}

MatrixXd Cholesky::inverse() const { return solved(MatrixXd::Identity(factor_.rows(), factor_.cols())); }

VectorXd solve_symmetric(const MatrixRef& A, const VectorXd& b) { return Eigen::LDLT<MatrixXd>(A).solve(b); }

MatrixXd semidefinite_root(const MatrixRef& A) {
  const Eigen::LDLT<MatrixXd> ldlt(A);
  const MatrixXd L = ldlt.matrixL();
  return ldlt.transpositionsP().transpose() *
         (L * ldlt.vectorD().cwiseMax(0.0).cwiseSqrt().asDiagonal()).eval();
}

SymmetricEigen symmetric_eigen(const MatrixRef& A) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(A);
  return {eigen.eigenvalues(), eigen.eigenvectors()};
}

}  // namespace limber
