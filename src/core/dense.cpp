// SPDX-License-Identifier: MIT
#include "limber/core/dense.hpp"

namespace limber {

using Eigen::Lower;
using Eigen::MatrixXd;
using Eigen::OnTheRight;
using Eigen::Ref;
using Eigen::VectorBlock;
using Eigen::VectorXd;

MatrixXd multiply(const MatrixRef& A, const MatrixRef& B) { return A * B; }
MatrixXd multiply(const Transposed& A, const MatrixRef& B) { return A.matrix.transpose() * B; }
MatrixXd multiply(const MatrixRef& A, const Transposed& B) { return A * B.matrix.transpose(); }

MatrixXd congruence(const MatrixRef& A, const MatrixRef& U) {
  return multiply(multiply(A, U), transposed(A));
}
MatrixXd congruence(const Transposed& A, const MatrixRef& U) { return multiply(multiply(A, U), A.matrix); }

void add_product(Ref<MatrixXd> C, double alpha, const MatrixRef& A, const MatrixRef& B) {
  C.noalias() += alpha * A * B;
}

void add_product(Ref<MatrixXd> C, double alpha, const Transposed& A, const MatrixRef& B) {
  C.noalias() += alpha * A.matrix.transpose() * B;
}

void add_product(Ref<MatrixXd> C, double alpha, const MatrixRef& A, const Transposed& B) {
  C.noalias() += alpha * A * B.matrix.transpose();
}

void add_lower_product(Ref<MatrixXd> C, const MatrixRef& A, const Transposed& B) {
  C.triangularView<Lower>() += A * B.matrix.transpose();
}

void add_outer(Ref<MatrixXd> S, double alpha, const MatrixRef& W) {
  S.selfadjointView<Lower>().rankUpdate(W, alpha);
}

MatrixXd symmetric_part(const MatrixRef& A) { return 0.5 * (A + A.transpose()); }

// Eigen solves for nothing at its peril.

void solve_lower(const MatrixRef& L, Ref<MatrixXd> X) {
  if (X.size() > 0) {
    L.triangularView<Lower>().solveInPlace(X);
  }
}

void solve_lower(const Transposed& L, Ref<MatrixXd> X) {
  if (X.size() > 0) {
    L.matrix.triangularView<Lower>().transpose().solveInPlace(X);
  }
}

void solve_lower(const MatrixRef& L, VectorXd& x) { solve_lower(L, x.head(x.size())); }

void solve_lower(const MatrixRef& L, VectorBlock<VectorXd> x) {
  if (x.size() > 0) {
    L.triangularView<Lower>().solveInPlace(x);
  }
}

void solve_lower_from_right(const MatrixRef& L, Ref<MatrixXd> X) {
  if (X.size() > 0) {
    L.triangularView<Lower>().solveInPlace<OnTheRight>(X);
  }
}

void solve_lower_from_right(const Transposed& L, Ref<MatrixXd> X) {
  if (X.size() > 0) {
    L.matrix.triangularView<Lower>().transpose().solveInPlace<OnTheRight>(X);
  }
}

}  // namespace limber
