// SPDX-License-Identifier: MIT
#include "limber/update/null_space_projection.hpp"

#include <algorithm>
#include <utility>

#include "limber/core/factors.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr Index kPanel = 64;  // rows that are reflected at a time: they stay in the cache

}  // namespace

NullSpaceProjection::NullSpaceProjection(const Eigen::Ref<const MatrixXd>& A) {
  const Index rank = A.cols();
  V_ = A;
  T_.setZero(rank, rank);
  if (rank == 0) {
    return;
  }
  HouseholderQr qr = householder_qr(A);
  V_ = std::move(qr.factors);
  V_.triangularView<Eigen::StrictlyUpper>().setZero();
  V_.diagonal().setOnes();
  // Compact WY: T(k,k) = tau_k, T(0:k,k) = -tau_k T(0:k,0:k) V(:,0:k)ᵀ V(:,k).
  for (Index k = 0; k < rank; ++k) {
    const double tau = qr.tau(k);
    T_(k, k) = tau;
    if (k > 0) {
      T_.col(k).head(k) = T_.topLeftCorner(k, k) * (V_.leftCols(k).transpose() * V_.col(k)) * -tau;
    }
  }
}

void NullSpaceProjection::apply_left(Eigen::Ref<MatrixXd> x) const {
  if (rank() > 0) {
    add_product(x, -1.0, V_, multiply(transposed(T_), multiply(transposed(V_), x)));
  }
}

void NullSpaceProjection::apply_right(Eigen::Ref<MatrixXd> x) const {
  if (rank() == 0) {
    return;
  }
  if (rank() == 1) {  // known to be vectors, Eigen does not pack them for a matrix product
    const VectorXd y = x * (T_(0, 0) * V_.col(0));
    x.noalias() -= y * V_.col(0).transpose();
    return;
  }
  const MatrixXd VT = multiply(V_, T_);
  for (Index row = 0; row < x.rows(); row += kPanel) {
    auto panel = x.middleRows(row, std::min(kPanel, x.rows() - row));
    add_product(panel, -1.0, multiply(panel, VT), transposed(V_));
  }
}

}  // namespace limber
