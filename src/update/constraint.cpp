// SPDX-License-Identifier: MIT
#include "limber/update/constraint.hpp"

#include <algorithm>

#include "limber/core/factors.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

/// The smallest singular value of R is at least the inverse of the Frobenius norm of its inverse.
bool is_surely_strong(const MatrixXd& R) {
  if (!(R.diagonal().cwiseAbs().minCoeff() > kWeakDirection)) {
    return false;
  }
  const MatrixXd inverse = R.triangularView<Eigen::Upper>().solve(MatrixXd::Identity(R.rows(), R.cols()));
  return inverse.norm() < 1.0 / kWeakDirection;
}

}  // namespace

MatrixXd strong_combinations(const Eigen::Ref<const MatrixXd>& D) {
  if (D.size() == 0) {
    return MatrixXd(D.cols(), 0);
  }
  const MatrixXd I = MatrixXd::Identity(D.cols(), D.cols());
  if (D.cols() == 1) {  // what the epipolar rows leave, as a rule
    return I.leftCols(D.norm() >= kWeakDirection ? 1 : 0);
  }
  const Index k = std::min(D.rows(), D.cols());
  const MatrixXd R = householder_qr(D).R();
  if (k == D.cols() && is_surely_strong(R)) {
    return I;  // its own basis
  }
  const RightSingular svd = right_singular(R);
  return svd.V.leftCols((svd.values.array() >= kWeakDirection).count());
}

MatrixXd strong_directions(const Eigen::Ref<const MatrixXd>& D) {
  const MatrixXd T = strong_combinations(D);
  return T.cols() == D.cols() && T.isIdentity(0.0) ? MatrixXd(D) : multiply(D, T);
}

}  // namespace limber
