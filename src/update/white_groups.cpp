// SPDX-License-Identifier: MIT
#include "limber/update/white_groups.hpp"

#include "limber/core/factors.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Only the lower triangle is right.
MatrixXd own_covariance(const RowGroup& group, const MatrixXd& S) {
  const Index rows = group.rows;
  if (group.fourth < 0) {
    return S.block(group.row, group.row, rows, rows);
  }
  MatrixXd out = MatrixXd::Identity(rows + 1, rows + 1);
  out.topLeftCorner(rows, rows) = S.block(group.row, group.row, rows, rows);
  if (group.fourth < S.rows()) {
    out.row(rows).head(rows) = S.row(group.fourth).segment(group.row, rows);
    out(rows, rows) = S(group.fourth, group.fourth);
  }
  return out;
}

}  // namespace

MatrixXd rows_of(const RowGroup& group, const MatrixXd& X) {
  if (group.fourth < 0) {
    return X.middleRows(group.row, group.rows);
  }
  MatrixXd out(group.rows + 1, X.cols());
  out.topRows(group.rows) = X.middleRows(group.row, group.rows);
  out.bottomRows<1>() = X.row(group.fourth);
  return out;
}

WhiteGroups white_groups(const VectorXd& r, const MatrixXd& S, const MatrixXd& A,
                         const std::vector<RowGroup>& groups) {
  WhiteGroups out{VectorXd(r.size()), MatrixXd(A.rows(), A.cols()), {}};
  Index row = 0;
  for (const RowGroup& group : groups) {
    const Cholesky root(own_covariance(group, S));
    const Index rows = root.factor().rows();
    out.r.segment(row, rows) = rows_of(group, r);
    out.A.middleRows(row, rows) = rows_of(group, A);
    solve_lower(root.factor(), out.r.segment(row, rows));
    solve_lower(root.factor(), out.A.middleRows(row, rows));
    out.groups.push_back({row, rows, group.own});
    row += rows;
  }
  return out;
}

}  // namespace limber
