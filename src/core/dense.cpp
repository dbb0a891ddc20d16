// SPDX-License-Identifier: MIT
#include "limber/core/dense.hpp"

#include <algorithm>

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

namespace {

constexpr Eigen::Index kStrip = 64;  // columns: a product below the diagonal is faster than a triangle of one

/// square(first, columns) and below(first, columns, rows) of each strip of the lower triangle of n×n.
template <typename Square, typename Below>
void for_each_strip(Eigen::Index n, Square square, Below below) {
  for (Eigen::Index first = 0; first < n; first += kStrip) {
    const Eigen::Index columns = std::min(kStrip, n - first), rows = n - first - columns;
    square(first, columns);
    if (rows > 0) {
      below(first, columns, rows);
    }
  }
}

}  // namespace

void add_lower_product(Ref<MatrixXd> C, const MatrixRef& A, const Transposed& B) {
  for_each_strip(
      C.rows(),
      [&](Eigen::Index first, Eigen::Index columns) {
        C.block(first, first, columns, columns).triangularView<Lower>() +=
            A.middleRows(first, columns) * B.matrix.middleRows(first, columns).transpose();
      },
      [&](Eigen::Index first, Eigen::Index columns, Eigen::Index rows) {
        add_product(C.block(first + columns, first, rows, columns), 1.0, A.bottomRows(rows),
                    transposed(B.matrix.middleRows(first, columns)));
      });
}

void add_outer(Ref<MatrixXd> S, double alpha, const MatrixRef& W) {
  for_each_strip(
      S.rows(),
      [&](Eigen::Index first, Eigen::Index columns) {
        S.block(first, first, columns, columns)
            .selfadjointView<Lower>()
            .rankUpdate(W.middleRows(first, columns), alpha);
      },
      [&](Eigen::Index first, Eigen::Index columns, Eigen::Index rows) {
        add_product(S.block(first + columns, first, rows, columns), alpha, W.bottomRows(rows),
                    transposed(W.middleRows(first, columns)));
      });
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
