// SPDX-License-Identifier: MIT
#include "limber/update/constraint.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr Index kPanel = 64;  // rows that are reflected at a time: what is copied of them stays in the cache

/// Columns of `from` at `places`, side by side. (An indexed view would copy number by number.)
template <typename From>
void gather_columns(const From& from, const std::vector<Index>& places, MatrixXd& to) {
  to.resize(from.rows(), static_cast<Index>(places.size()));
  for (std::size_t k = 0; k < places.size(); ++k) {
    to.col(static_cast<Index>(k)) = from.col(places[k]);
  }
}

/// The smallest singular value of R is at least the inverse of the Frobenius norm of its inverse.
bool is_surely_strong(const MatrixXd& R) {
  if (!(R.diagonal().cwiseAbs().minCoeff() > kWeakDirection)) {
    return false;
  }
  const MatrixXd inverse = R.triangularView<Eigen::Upper>().solve(MatrixXd::Identity(R.rows(), R.cols()));
  return inverse.norm() < 1.0 / kWeakDirection;
}

/// QR of a basis of what D spans without its weak directions.
Eigen::HouseholderQR<MatrixXd> factorise_strong(const MatrixXd& D) {
  if (D.rows() >= D.cols()) {
    Eigen::HouseholderQR<MatrixXd> qr(D);
    if (is_surely_strong(qr.matrixQR().topRows(D.cols()))) {
      return qr;  // no direction is weak: D is its own basis
    }
  }
  return Eigen::HouseholderQR<MatrixXd>(strong_directions(D));
}

}  // namespace

MatrixXd strong_directions(const Eigen::Ref<const MatrixXd>& D) {
  if (D.cols() == 0) {
    return D;
  }
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(D.transpose() * D);
  Index weak = 0;
  while (weak < D.cols() && eigen.eigenvalues()(weak) < kWeakDirection * kWeakDirection) {
    ++weak;
  }
  return D * eigen.eigenvectors().rightCols(D.cols() - weak);
}

NullSpaceProjection::NullSpaceProjection(const Eigen::Ref<const MatrixXd>& D) {
  // From the last row up, so that the constrained rows, which Householder QR puts first, already stand near
  // the end.
  for (Index row = D.rows() - 1; row >= 0; --row) {
    if (!D.row(row).isZero(0.0)) {
      touched_.push_back(row);
    }
  }
  if (touched_.empty()) {
    return;
  }
  const Eigen::HouseholderQR<MatrixXd> qr = factorise_strong(D(touched_, Eigen::all));
  rank_ = std::min(qr.cols(), qr.rows());
  if (rank_ == 0) {
    return;
  }
  V_ = qr.matrixQR().leftCols(rank_);
  V_.triangularView<Eigen::StrictlyUpper>().setZero();
  V_.diagonal().setOnes();
  // Compact WY: T(k,k) = tau_k, T(0:k,k) = -tau_k T(0:k,0:k) V(:,0:k)ᵀ V(:,k).
  T_.setZero(rank_, rank_);
  for (Index k = 0; k < rank_; ++k) {
    const double tau = qr.hCoeffs()(k);
    T_(k, k) = tau;
    if (k > 0) {
      T_.col(k).head(k) = T_.topLeftCorner(k, k) * (V_.leftCols(k).transpose() * V_.col(k)) * -tau;
    }
  }
  order_tail(D.rows());
}

void NullSpaceProjection::order_tail(Index rows) {
  tail_start_ = touched_[static_cast<std::size_t>(rank_ - 1)];
  std::vector<bool> constrained(static_cast<std::size_t>(rows - tail_start_), false);
  for (Index k = 0; k < rank_; ++k) {
    constrained[static_cast<std::size_t>(touched_[static_cast<std::size_t>(k)] - tail_start_)] = true;
  }
  for (const bool wanted : {false, true}) {
    for (std::size_t k = 0; k < constrained.size(); ++k) {
      if (constrained[k] == wanted) {
        tail_order_.push_back(static_cast<Index>(k));
      }
    }
  }
}

void NullSpaceProjection::apply_left(Eigen::Ref<MatrixXd> x) const {
  if (rank_ == 0) {
    return;
  }
  MatrixXd rows = x(touched_, Eigen::all);
  rows.noalias() -= V_ * (T_.transpose() * (V_.transpose() * rows)).eval();
  x(touched_, Eigen::all) = rows;
  auto tail = x.bottomRows(x.rows() - tail_start_);
  tail = tail(tail_order_, Eigen::all).eval();
}

void NullSpaceProjection::apply_right(Eigen::Ref<MatrixXd> x) const {
  if (rank_ == 0) {
    return;
  }
  const MatrixXd VT = V_ * T_;
  MatrixXd cols, Y, tail;
  for (Index row = 0; row < x.rows(); row += kPanel) {
    auto panel = x.middleRows(row, std::min(kPanel, x.rows() - row));
    gather_columns(panel, touched_, cols);
    Y.noalias() = cols * VT;
    cols.noalias() -= Y * V_.transpose();
    for (std::size_t k = 0; k < touched_.size(); ++k) {
      panel.col(touched_[k]) = cols.col(static_cast<Index>(k));
    }
    auto last = panel.rightCols(x.cols() - tail_start_);
    gather_columns(last, tail_order_, tail);
    last = tail;
  }
}

void NullSpaceProjection::apply_both(Eigen::Ref<MatrixXd> S) const {
  if (rank_ == 0) {
    return;
  }
  const Index m = S.rows();
  MatrixXd V = MatrixXd::Zero(m, rank_);
  V(touched_, Eigen::all) = V_;
  // Qᵀ S Q = S − V Yᵀ − Y Vᵀ with Y = A − ½ V Tᵀ Vᵀ A, A = S V T.
  MatrixXd touched;
  gather_columns(S, touched_, touched);
  MatrixXd Y = touched * (V_ * T_).eval();
  Y -= 0.5 * V * (T_.transpose() * (V.transpose() * Y)).eval();
  MatrixXd left(m, 2 * rank_), right(m, 2 * rank_);
  left << V, Y;
  right << Y, V;
  S.triangularView<Eigen::Lower>() -= left * right.transpose();

  auto beside = S.bottomLeftCorner(m - tail_start_, tail_start_);
  beside = beside(tail_order_, Eigen::all).eval();
  auto corner = S.bottomRightCorner(m - tail_start_, m - tail_start_);
  const MatrixXd full = corner.selfadjointView<Eigen::Lower>();
  corner = full(tail_order_, tail_order_);
}

}  // namespace limber
