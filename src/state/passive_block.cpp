// SPDX-License-Identifier: MIT
#include "limber/state/passive_block.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <utility>

#include "limber/core/factors.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr Index kShares = 4;         // frames in which an epoch's work on G and E is done
constexpr Index kSpareRows = 96;     // of G, for triplets that come back
constexpr double kRounding = 1e-11;  // of a variance, as much as rounding may have taken of it
constexpr double kSingular = 1e-13;  // eigenvalue of a correlation matrix that rounding may have made

/// The factor of a covariance. Where states are known together far better than each alone, as poses and
/// points of a filter that is lost by hundreds of metres, rounding takes the smallest eigenvalue of the
/// correlation below zero: P is then made larger by less than any update rounds.
Cholesky factor_of(MatrixXd& P) {
  Cholesky llt(P);
  if (!llt.succeeded()) {
    P.diagonal() *= 1.0 + kRounding;
    llt = Cholesky(P);
  }
  return llt;
}

/// Where the triplets of `count` leading scalars start.
std::vector<Index> leading(Index count) {
  std::vector<Index> out;
  for (Index start = 0; start < count; start += kTriplet) {
    out.push_back(start);
  }
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

/// The rows of the triplets at `rows` into those of `out`, which is as wide; zero where `from` ends before
/// (or starts behind) one.
void pick_rows(const MatrixRef& from, std::span<const Index> rows, Eigen::Ref<MatrixXd> out) {
  for (Index column = 0; column < from.cols(); ++column) {
    const auto source = from.col(column);
    auto target = out.col(column);
    Index to = 0;
    for (const Index row : rows) {
      if (row >= 0 && row < from.rows()) {
        target.segment<kTriplet>(to) = source.segment<kTriplet>(row);
      } else {
        target.segment<kTriplet>(to).setZero();
      }
      to += kTriplet;
    }
  }
}

MatrixXd picked(const MatrixXd& from, std::span<const Index> rows, std::span<const Index> cols) {
  MatrixXd out(kTriplet * static_cast<Index>(rows.size()), kTriplet * static_cast<Index>(cols.size()));
  for (std::size_t k = 0; k < cols.size(); ++k) {
    pick_rows(from.middleCols<kTriplet>(cols[k]), rows,
              out.middleCols<kTriplet>(kTriplet * static_cast<Index>(k)));
  }
  return out;
}

std::vector<Index> shifted(std::vector<Index> starts, Index by) {
  for (Index& start : starts) {
    start += by;
  }
  return starts;
}

/// [body | body once more | what follows] of the covariance of [body | what follows].
MatrixXd with_clone(const MatrixXd& P, Index body) {
  MatrixXd out(P.rows() + body, P.cols() + body);
  out.bottomRightCorner(P.rows(), P.cols()) = P;
  out.bottomLeftCorner(P.rows(), body) = P.leftCols(body);
  out.topLeftCorner(body, body) = P.topLeftCorner(body, body);
  out.topRightCorner(body, P.cols()) = P.topRows(body);
  return out;
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

bool PassiveBlock::change_epoch(Covariance& P, Index body_size, const EpochChange& change) {
  const MatrixXd dense = P.dense();
  const std::vector<Index> z = leading(body_size) + change.kept;
  // What leaves: first the retired, then the rest (the old clone of the body among them).
  const std::vector<Index> left = change.retired + change.dropped;
  MatrixXd P_zz = picked(dense, z, z);
  if (empty() && change.retired.empty()) {
    Gt_ = {};
    P.assign(P_zz);
    return true;
  }
  const Cholesky llt = factor_of(P_zz);
  if (!llt.succeeded()) {
    return false;
  }
  // left = A z + u, u independent of z.
  const MatrixXd P_zl = picked(dense, z, left);
  MatrixXd At = llt.solve(P_zl);
  MatrixXd U = picked(dense, left, left);
  add_product(U, -1.0, transposed(P_zl), At);
  U = symmetric_part(U);

  // Of x_d = G z + e, and of the retired, who come first in what leaves: G grows by G_uᵀ A, E by G_uᵀ U G_u.
  const Index old_size = size(), added = kTriplet * static_cast<Index>(change.retired.size());
  const MatrixRef Gt_old = Gt_.settle_all();
  MatrixXd G_u(At.cols(), old_size + added);
  pick_rows(Gt_old, shifted(left, -body_size), G_u.leftCols(old_size));
  G_u.rightCols(added).setIdentity();
  MatrixXd Gt(At.rows() + kSpareRows, old_size + added);
  pick_rows(Gt_old, shifted(z, -body_size), Gt.topLeftCorner(At.rows(), old_size));
  Gt.rightCols(added).setZero();
  Gt_.assign_in_shares(std::move(Gt), std::move(At), G_u, kShares);
  E_.append(added);
  E_.add_in_shares(semidefinite_root(U).transpose(), std::move(G_u), kShares);

  P.assign(with_clone(P_zz, body_size));
  return true;
}

void PassiveBlock::recall(Covariance& P, Index body_size, std::span<const Index> rows) {
  const Index before = P.size(), count = kTriplet * static_cast<Index>(rows.size());
  MatrixXd Gt_back(z_size(), count);
  for (Index k = 0; k < count; k += kTriplet) {
    Gt_back.middleCols<kTriplet>(k) = Gt_.triplet(rows[static_cast<std::size_t>(k / kTriplet)]);
  }
  MatrixXd E_back, E_between(count, count);
  E_.gather(rows, E_back);
  pick_rows(E_back, rows, E_between);

  MatrixXd from_z = MatrixXd::Zero(before, count);
  from_z.middleRows(body_size, z_size()) = Gt_back;
  MatrixXd columns(before + count, count);
  columns.topRows(before) = P.times(from_z);
  columns.bottomRows(count) = multiply(transposed(Gt_back), columns.middleRows(body_size, z_size()));
  columns.bottomRows(count) += E_between;
  append(P, columns);
  for (Index k = 0; k < count; k += kTriplet) {
    P.swap_triplets(body_size + z_size() + k, before + k);
  }

  // The others' remainders e = B e_back + e', and e_back = x_back − G_back z.
  const MatrixXd F = root_of_pseudo_inverse(E_between);
  const MatrixXd W = multiply(E_back, F);
  const MatrixXd Bt = multiply(F, transposed(W));
  Gt_.add_product_above(-1.0, Gt_back, Bt);
  Gt_.append_rows(Bt);
  E_.subtract_outer(W);
  std::vector<Index> leaving(rows.begin(), rows.end());
  std::sort(leaving.rbegin(), leaving.rend());
  for (const Index row : leaving) {
    remove(row);
  }
}

Index PassiveBlock::remove(Index row) {
  Gt_.remove_triplet(row);
  return E_.remove_triplet(row);
}

MatrixXd PassiveBlock::cross(const Covariance& P, Index body_size, Index row) const {
  MatrixXd from_z = MatrixXd::Zero(P.size(), kTriplet);
  from_z.middleRows(body_size, z_size()) = Gt_.triplet(row);
  return P.times(from_z).transpose();
}

Eigen::Matrix3d PassiveBlock::triplet_block(const Covariance& P, Index body_size, Index row,
                                            Index other) const {
  return E_.triplet_block(row, other) +
         cross(P, body_size, row).middleCols(body_size, z_size()) * Gt_.triplet(other);
}

VectorXd PassiveBlock::correction(const Eigen::Ref<const VectorXd>& dz) const {
  return Gt_.transposed_times(dz);
}

Eigen::Vector3d PassiveBlock::correction(Index row, const Eigen::Ref<const VectorXd>& dz) const {
  return Gt_.triplet(row).transpose() * dz;
}

void PassiveBlock::settle() {
  Gt_.settle();
  E_.settle();
}

void PassiveBlock::settle_all() {
  Gt_.settle_all();
  E_.settle_all();
}

void PassiveBlock::couple_row(Index row, Index column, const Eigen::Matrix3d& C) {
  Gt_.add_block(column, row, C.transpose());
}

void PassiveBlock::couple_columns(Index other, const Eigen::Ref<const MatrixXd>& C) {
  Gt_.add_to_rows(other, -C.transpose());
}

void PassiveBlock::couple_column(Index column, Index other, const Eigen::Matrix3d& C) {
  Gt_.couple_rows(other, column, -C.transpose());
}

void PassiveBlock::transform_row(Index row, const Eigen::Matrix3d& M) {
  Gt_.transform_triplet(row, M.transpose());
  E_.transform_triplet(row, M);
}

void PassiveBlock::transform_column(Index column, const Eigen::Matrix3d& M) {
  Gt_.transform_rows(column, M.inverse().transpose());
}

}  // namespace limber
