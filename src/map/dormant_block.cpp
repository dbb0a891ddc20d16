// SPDX-License-Identifier: MIT
#include "limber/map/dormant_block.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <numeric>

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

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

/// Copies what lies between the removed rows, run by run. (An indexed view would copy number by number.)
/// @param removed  sorted
MatrixXd without_rows(const MatrixXd& from, const std::vector<Index>& removed) {
  MatrixXd to(from.rows() - static_cast<Index>(removed.size()), from.cols());
  Index in = 0, out = 0;
  const auto copy_to = [&](Index end) {
    to.middleRows(out, end - in) = from.middleRows(in, end - in);
    out += end - in;
    in = end + 1;
  };
  for (const Index row : removed) {
    copy_to(row);
  }
  copy_to(from.rows());
  return to;
}

MatrixXd without_columns(const MatrixXd& from, const std::vector<Index>& removed) {
  MatrixXd to(from.rows(), from.cols() - static_cast<Index>(removed.size()));
  Index in = 0, out = 0;
  const auto copy_to = [&](Index end) {
    to.middleCols(out, end - in) = from.middleCols(in, end - in);
    out += end - in;
    in = end + 1;
  };
  for (const Index column : removed) {
    copy_to(column);
  }
  copy_to(from.cols());
  return to;
}

/// F with F Fᵀ = A⁺, A symmetric positive semidefinite: directions that only rounding fills are left out.
MatrixXd root_of_pseudo_inverse(const MatrixXd& A) {
  const VectorXd scale = A.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(scale.asDiagonal() * A * scale.asDiagonal());
  const VectorXd& values = eigen.eigenvalues();
  const VectorXd root = (values.array() > kSingular * values.maxCoeff())
                            .select(values.cwiseInverse().cwiseSqrt(), VectorXd::Zero(values.size()));
  return scale.asDiagonal() * eigen.eigenvectors() * root.asDiagonal();
}

void set_covariance(Covariance& P, const MatrixXd& dense) {
  P = Covariance();
  P.append(dense.rows());
  P.set_diagonal_block(0, dense);
}

}  // namespace

bool DormantBlock::change_epoch(Covariance& P, Index body_size, const EpochChange& change) {
  const MatrixXd dense = P.dense();
  const std::vector<Index> body = counted(0, body_size);
  const std::vector<Index> z = body + scalars(change.kept);
  // What leaves: first the old z (its clone of the body among them) and the rest in any order.
  const std::vector<Index> retired = scalars(change.retired);
  const std::vector<Index> left = retired + scalars(change.dropped);
  const bool stays_empty = empty() && retired.empty();
  if (stays_empty) {
    G_.resize(0, 0);
    set_covariance(P, dense(z, z));
    return true;
  }
  const MatrixXd P_zz = dense(z, z);
  const Eigen::LLT<MatrixXd> llt(P_zz);
  if (llt.info() != Eigen::Success) {
    return false;
  }
  // left = A z + u, u independent of z.
  const MatrixXd P_zl = dense(z, left);
  const MatrixXd A = llt.solve(P_zl).transpose();
  MatrixXd U = dense(left, left) - A * P_zl;
  U = (0.5 * (U + U.transpose())).eval();

  const Index old_size = size(), old_z = z_size(), added = static_cast<Index>(retired.size());
  const auto old_column = [&](Index k) { return k >= body_size && k < body_size + old_z; };
  MatrixXd G_left = MatrixXd::Zero(old_size, static_cast<Index>(left.size()));
  MatrixXd G = MatrixXd::Zero(old_size + added, static_cast<Index>(z.size()));
  for (std::size_t k = 0; k < left.size() && old_size > 0; ++k) {
    if (old_column(left[k])) {
      G_left.col(static_cast<Index>(k)) = G_.col(left[k] - body_size);
    }
  }
  G.topRows(old_size).noalias() = G_left * A;
  for (std::size_t k = 0; k < z.size() && old_size > 0; ++k) {
    if (old_column(z[k])) {
      G.col(static_cast<Index>(k)).head(old_size) += G_.col(z[k] - body_size);
    }
  }
  G.bottomRows(added) = A.topRows(added);

  MatrixXd E(old_size + added, old_size + added);
  const MatrixXd G_U = G_left * U;
  E.topLeftCorner(old_size, old_size) = E_;
  E.topLeftCorner(old_size, old_size).noalias() += G_U * G_left.transpose();
  E.topRightCorner(old_size, added) = G_U.leftCols(added);
  E.bottomLeftCorner(added, old_size) = G_U.leftCols(added).transpose();
  E.bottomRightCorner(added, added) = U.topLeftCorner(added, added);

  G_ = std::move(G);
  E_ = std::move(E);
  const std::vector<Index> active = body + z;  // the clone is the body once more
  set_covariance(P, dense(active, active));
  return true;
}

void DormantBlock::recall(Covariance& P, Index body_size, std::span<const Index> rows) {
  const std::vector<Index> back = scalars(rows);
  const MatrixXd G_back = G_(back, Eigen::all);
  const MatrixXd E_back = E_(back, back);

  const MatrixXd dense = P.dense();
  const Index before = P.size(), count = static_cast<Index>(back.size());
  MatrixXd joint(before + count, before + count);
  joint.topLeftCorner(before, before) = dense;
  joint.bottomLeftCorner(count, before).noalias() = G_back * dense.middleRows(body_size, z_size());
  joint.bottomRightCorner(count, count).noalias() =
      joint.block(before, body_size, count, z_size()) * G_back.transpose();
  joint.bottomRightCorner(count, count) += E_back;
  set_covariance(P, joint);

  // The others' remainders e = B e_back + e', and e_back = x_back − G_back z.
  std::vector<Index> removed = back;
  std::sort(removed.begin(), removed.end());
  const MatrixXd F = root_of_pseudo_inverse(E_back);
  const MatrixXd W = without_rows(E_(Eigen::all, back), removed) * F;
  const MatrixXd B = W * F.transpose();
  MatrixXd G(size() - count, z_size() + count);
  G << without_rows(G_, removed), B;
  G.leftCols(z_size()).noalias() -= B * G_back;
  E_ = without_columns(without_rows(E_, removed), removed);
  E_.noalias() -= W * W.transpose();
  G_ = std::move(G);
}

Index DormantBlock::remove(Index row) {
  const Index last = size() - kTriplet;
  if (row != last) {
    G_.middleRows<kTriplet>(row) = G_.bottomRows<kTriplet>().eval();
    E_.middleRows<kTriplet>(row) = E_.bottomRows<kTriplet>().eval();
    E_.middleCols<kTriplet>(row) = E_.rightCols<kTriplet>().eval();
  }
  G_.conservativeResize(last, Eigen::NoChange);
  E_.conservativeResize(last, last);
  return last;
}

MatrixXd DormantBlock::cross(const Covariance& P, Index body_size, Index row) const {
  return G_.middleRows<kTriplet>(row) * P.block(body_size, 0, z_size(), P.size());
}

Eigen::Matrix3d DormantBlock::triplet_block(const Covariance& P, Index body_size, Index row,
                                            Index other) const {
  return E_.block<kTriplet, kTriplet>(row, other) + cross(P, body_size, row).middleCols(body_size, z_size()) *
                                                        G_.middleRows<kTriplet>(other).transpose();
}

void DormantBlock::transform_row(Index row, const Eigen::Matrix3d& M) {
  G_.middleRows<kTriplet>(row) = (M * G_.middleRows<kTriplet>(row)).eval();
  E_.middleRows<kTriplet>(row) = (M * E_.middleRows<kTriplet>(row)).eval();
  E_.middleCols<kTriplet>(row) = (E_.middleCols<kTriplet>(row) * M.transpose()).eval();
}

void DormantBlock::transform_column(Index column, const Eigen::Matrix3d& M) {
  G_.middleCols<kTriplet>(column) = (G_.middleCols<kTriplet>(column) * M.inverse()).eval();
}

}  // namespace limber
