// SPDX-License-Identifier: MIT
#include "limber/state/passive_block.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <numeric>
#include <utility>

#include "limber/core/factors.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr Index kShares = 8;         // frames in which an epoch's work on E is done
constexpr double kSingular = 1e-13;  // eigenvalue of a correlation matrix that rounding may have made

std::vector<Index> scalars(std::span<const Index> starts) {
  std::vector<Index> out;
  out.reserve(static_cast<std::size_t>(kTriplet) * starts.size());
  for (const Index start : starts) {
    for (Index k = 0; k < kTriplet; ++k) {
      out.push_back(start + k);
    }
  }
  return out;
}

std::vector<Index> counted(Index first, Index count) {
  std::vector<Index> out(static_cast<std::size_t>(count));
  std::iota(out.begin(), out.end(), first);
  return out;
}

std::vector<Index> operator+(std::vector<Index> a, const std::vector<Index>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// F with F Fᵀ = A⁺, A symmetric positive semidefinite: directions that only rounding fills are left out.
MatrixXd root_of_pseudo_inverse(const MatrixXd& A) {
  const VectorXd scale = A.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const SymmetricEigen eigen = symmetric_eigen(scale.asDiagonal() * A * scale.asDiagonal());
  const VectorXd& values = eigen.values;
  const VectorXd root = (values.array() > kSingular * values.maxCoeff())
                            .select(values.cwiseInverse().cwiseSqrt(), VectorXd::Zero(values.size()));
  return scale.asDiagonal() * eigen.vectors * root.asDiagonal();
}

/// Appends triplets with their columns: rows before beside their own.
void append(Covariance& P, const MatrixXd& columns) {
  const Index first = P.append(columns.cols());
  std::vector<Index> starts;
  for (Index at = first; at < P.size(); at += kTriplet) {
    starts.push_back(at);
  }
  P.scatter(starts, columns);
}

}  // namespace

/// Rows of Gᵀ of states of P, zero where a state is no part of z.
MatrixXd PassiveBlock::rows_of(const std::vector<Index>& states, Index body_size) const {
  MatrixXd out(static_cast<Index>(states.size()), size());
  for (Index column = 0; column < out.cols(); ++column) {
    for (std::size_t k = 0; k < states.size(); ++k) {
      const Index row = states[k] - body_size;
      out(static_cast<Index>(k), column) = row >= 0 && row < z_size() ? Gt_(row, column) : 0.0;
    }
  }
  return out;
}

bool PassiveBlock::change_epoch(Covariance& P, Index body_size, const EpochChange& change) {
  const MatrixXd dense = P.dense();
  const std::vector<Index> body = counted(0, body_size);
  const std::vector<Index> z = body + scalars(change.kept);
  // What leaves: first the retired, then the rest (the old clone of the body among them).
  const std::vector<Index> retired = scalars(change.retired);
  const std::vector<Index> left = retired + scalars(change.dropped);
  const MatrixXd P_zz = dense(z, z);
  if (empty() && retired.empty()) {
    Gt_.resize(0, 0);
    P.assign(P_zz);
    return true;
  }
  const Cholesky llt(P_zz);
  if (!llt.succeeded()) {
    return false;
  }
  // left = A z + u, u independent of z.
  const MatrixXd P_zl = dense(z, left);
  const MatrixXd At = llt.solve(P_zl);
  MatrixXd U = dense(left, left);
  add_product(U, -1.0, transposed(P_zl), At);
  U = symmetric_part(U);

  const Index old_size = size(), added = static_cast<Index>(retired.size());
  const Index left_size = static_cast<Index>(left.size());
  const MatrixXd Gt_left = rows_of(left, body_size);
  MatrixXd Gt(At.rows(), old_size + added);
  Gt.leftCols(old_size) = rows_of(z, body_size);
  add_product(Gt.leftCols(old_size), 1.0, At, Gt_left);
  Gt.rightCols(added) = At.leftCols(added);
  Gt_ = std::move(Gt);

  // E becomes [Gᵀ; I 0] U [G, [I; 0]] beside what it was: the retired come first in u.
  MatrixXd G_u(left_size, old_size + added);
  G_u.leftCols(old_size) = Gt_left;
  G_u.rightCols(added).setIdentity();
  E_.settle_all();
  E_.append(added);
  E_.add_in_shares(semidefinite_root(U).transpose(), std::move(G_u), kShares);

  const std::vector<Index> active = body + z;  // the clone is the body once more
  P.assign(dense(active, active));
  return true;
}

void PassiveBlock::recall(Covariance& P, Index body_size, std::span<const Index> rows) {
  const std::vector<Index> back = scalars(rows);
  const Index before = P.size(), count = static_cast<Index>(back.size());
  const MatrixXd Gt_back = Gt_(Eigen::all, back);
  MatrixXd E_back;
  E_.gather(rows, E_back);

  MatrixXd from_z = MatrixXd::Zero(before, count);
  from_z.middleRows(body_size, z_size()) = Gt_back;
  MatrixXd columns(before + count, count);
  columns.topRows(before) = P.times(from_z);
  columns.bottomRows(count) = multiply(transposed(Gt_back), columns.middleRows(body_size, z_size()));
  columns.bottomRows(count) += E_back(back, Eigen::all);
  append(P, columns);
  for (Index k = 0; k < count; k += kTriplet) {
    P.swap_triplets(body_size + z_size() + k, before + k);
  }

  // The others' remainders e = B e_back + e', and e_back = x_back − G_back z.
  const MatrixXd F = root_of_pseudo_inverse(E_back(back, Eigen::all));
  const MatrixXd W = multiply(E_back, F);
  const MatrixXd Bt = multiply(F, transposed(W));
  MatrixXd Gt(z_size() + count, size());
  Gt << Gt_, Bt;
  add_product(Gt.topRows(z_size()), -1.0, Gt_back, Bt);
  Gt_ = std::move(Gt);
  E_.subtract_outer(W);
  std::vector<Index> leaving(rows.begin(), rows.end());
  std::sort(leaving.rbegin(), leaving.rend());
  for (const Index row : leaving) {
    remove(row);
  }
}

Index PassiveBlock::remove(Index row) {
  const Index last = E_.remove_triplet(row);
  if (row != last) {
    Gt_.middleCols<kTriplet>(row) = Gt_.rightCols<kTriplet>().eval();
  }
  Gt_.conservativeResize(Eigen::NoChange, last);
  return last;
}

MatrixXd PassiveBlock::cross(const Covariance& P, Index body_size, Index row) const {
  MatrixXd from_z = MatrixXd::Zero(P.size(), kTriplet);
  from_z.middleRows(body_size, z_size()) = Gt_.middleCols<kTriplet>(row);
  return P.times(from_z).transpose();
}

Eigen::Matrix3d PassiveBlock::triplet_block(const Covariance& P, Index body_size, Index row,
                                            Index other) const {
  return E_.triplet_block(row, other) +
         cross(P, body_size, row).middleCols(body_size, z_size()) * Gt_.middleCols<kTriplet>(other);
}

VectorXd PassiveBlock::correction(const Eigen::Ref<const VectorXd>& dz) const { return Gt_.transpose() * dz; }

Eigen::Vector3d PassiveBlock::correction(Index row, const Eigen::Ref<const VectorXd>& dz) const {
  return Gt_.middleCols<kTriplet>(row).transpose() * dz;
}

void PassiveBlock::couple_row(Index row, Index column, const Eigen::Matrix3d& C) {
  Gt_.block<kTriplet, kTriplet>(column, row) += C.transpose();
}

void PassiveBlock::couple_columns(Index other, const Eigen::Ref<const MatrixXd>& C) {
  Gt_.middleRows<kTriplet>(other) -= multiply(transposed(C), Gt_);
}

void PassiveBlock::couple_column(Index column, Index other, const Eigen::Matrix3d& C) {
  Gt_.middleRows<kTriplet>(other) -= (C.transpose() * Gt_.middleRows<kTriplet>(column)).eval();
}

void PassiveBlock::transform_row(Index row, const Eigen::Matrix3d& M) {
  Gt_.middleCols<kTriplet>(row) = (Gt_.middleCols<kTriplet>(row) * M.transpose()).eval();
  E_.transform_triplet(row, M);
}

void PassiveBlock::transform_column(Index column, const Eigen::Matrix3d& M) {
  Gt_.middleRows<kTriplet>(column) = (M.inverse().transpose() * Gt_.middleRows<kTriplet>(column)).eval();
}

}  // namespace limber
