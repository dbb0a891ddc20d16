// SPDX-License-Identifier: MIT
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>

#include "limber/core/factors.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Ref;
using Eigen::Upper;
using Eigen::VectorXd;

MatrixXd HouseholderQr::R() const { return factors.topRows(tau.size()).triangularView<Upper>(); }

MatrixXd HouseholderQr::Q() const { return Eigen::householderSequence(factors, tau); }

void HouseholderQr::apply_Qt(Ref<MatrixXd> X) const {
  X.applyOnTheLeft(Eigen::householderSequence(factors, tau).adjoint());
}

void HouseholderQr::apply_Qt(VectorXd& x) const {
  x.applyOnTheLeft(Eigen::householderSequence(factors, tau).adjoint());
}

HouseholderQr householder_qr(const MatrixRef& A) {
  const Eigen::HouseholderQR<MatrixXd> qr(A);
  return {qr.matrixQR(), qr.hCoeffs()};
}

MatrixXd PivotedQr::turned_rows(Index rows) const {
  MatrixXd out = MatrixXd::Zero(rows, qr.factors.cols());
  out.triangularView<Upper>() = qr.factors.topRows(rows);
  out *= Pi.transpose();
  return out;
}

PivotedQr pivoted_qr(const MatrixRef& A) {
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(A);
  return {{qr.matrixQR(), qr.hCoeffs()}, qr.colsPermutation(), qr.rank(), qr.maxPivot()};
}

RightSingular right_singular(const MatrixRef& A) {
  const Eigen::JacobiSVD<MatrixXd> svd(A, Eigen::ComputeFullV);
  return {svd.singularValues(), svd.matrixV()};
}

PseudoInverse pseudo_inverse(const MatrixRef& A, const VectorXd& b) {
  const Eigen::CompleteOrthogonalDecomposition<MatrixXd> factors(A);
  return {factors.pseudoInverse(), factors.solve(b)};
}

MatrixXd pseudo_inverse(const MatrixRef& A) {
  return Eigen::CompleteOrthogonalDecomposition<MatrixXd>(A).pseudoInverse();
}

}  // namespace limber
