// SPDX-License-Identifier: MIT
#include "limber/update/whiten.hpp"

#include "limber/core/dense.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr Index kBlock = 8;  // columns that are solved at once, one cache line of a row of L
using SquareBlock = Eigen::Matrix<double, kBlock, kBlock>;

/// X := X L⁻ᵀ for kBlock columns, by the inverse of L: rows of X in blocks that fit the registers.
void whiten_block(const SquareBlock& L, Eigen::Ref<MatrixXd> X) {
  const SquareBlock right =
      L.triangularView<Eigen::Lower>().solve(SquareBlock(SquareBlock::Identity())).transpose();
  Index row = 0;
  for (; row + kBlock <= X.rows(); row += kBlock) {
    const SquareBlock rows = X.middleRows<kBlock>(row);
    X.middleRows<kBlock>(row).noalias() = rows.lazyProduct(right);
  }
  for (; row < X.rows(); ++row) {
    const Eigen::Matrix<double, 1, kBlock> rest = X.row(row);
    X.row(row).noalias() = rest.lazyProduct(right);
  }
}

}  // namespace

void whiten_columns(const Eigen::Ref<const MatrixXd>& L, Eigen::Ref<MatrixXd> X) {
  const Index m = L.rows();
  if (X.size() == 0) {  // Eigen solves for nothing at its peril
    return;
  }
  if (m == kBlock) {
    whiten_block(L, X);
    return;
  }
  if (m < kBlock) {
    solve_lower_from_right(transposed(L), X);
    return;
  }
  const Index blocks = (m + kBlock - 1) / kBlock;
  const Index first = kBlock * (blocks / 2), rest = m - first;
  whiten_columns(L.topLeftCorner(first, first), X.leftCols(first));
  add_product(X.rightCols(rest), -1.0, X.leftCols(first), transposed(L.bottomLeftCorner(rest, first)));
  whiten_columns(L.bottomRightCorner(rest, rest), X.rightCols(rest));
}

}  // namespace limber
