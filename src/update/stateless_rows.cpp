// SPDX-License-Identifier: MIT
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>

#include "limber/update/constraint.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double kNothing = 1e-12;  // of the largest entry: a row that says nothing

/// Stateless rows join the others, moved by no state.
void append(Innovation& innovation, const Eigen::Ref<const MatrixXd>& D,
            const Eigen::Ref<const VectorXd>& r) {
  const Index m = innovation.r.size(), q = r.size();
  innovation.r.conservativeResize(m + q);
  innovation.r.tail(q) = r;
  innovation.D.conservativeResize(m + q, Eigen::NoChange);
  innovation.D.bottomRows(q) = D;
  innovation.PHt.conservativeResize(Eigen::NoChange, m + q);
  innovation.PHt.rightCols(q).setZero();
  MatrixXd S = MatrixXd::Identity(m + q, m + q);
  S.topLeftCorner(m, m) = innovation.S;
  innovation.S = std::move(S);
}

/// F Fᵀ = Sigma, positive semidefinite.
MatrixXd square_root(const Eigen::Ref<const MatrixXd>& Sigma) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(Sigma);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

}  // namespace

void absorb_white(Innovation& innovation, const Eigen::Ref<const MatrixXd>& Sigma) {
  // With E: q×c the stateless D and Sigma = F Fᵀ, what they leave of dtheta is F (B Bᵀ)⁻¹ Fᵀ,
  // B Bᵀ = I + Fᵀ Eᵀ E F: no difference of large numbers, however large Sigma is.
  const MatrixXd F = square_root(Sigma);
  StatelessRows& stateless = innovation.stateless;
  const MatrixXd EF = stateless.D * F;
  const Eigen::LLT<MatrixXd> B(MatrixXd::Identity(F.cols(), F.cols()) + EF.transpose() * EF);
  MatrixXd DF = innovation.D * F;
  if (stateless.residual.size() > 0) {
    innovation.r.noalias() -= DF * B.solve(EF.transpose() * stateless.residual);
    innovation.D.noalias() -= DF * B.solve(EF.transpose() * stateless.D);
    const Eigen::LLT<MatrixXd> M(MatrixXd::Identity(EF.rows(), EF.rows()) + EF * EF.transpose());
    M.matrixL().solveInPlace(stateless.residual);
    M.matrixL().solveInPlace(stateless.D);
  }
  B.matrixL().transpose().solveInPlace<Eigen::OnTheRight>(DF);
  innovation.S.selfadjointView<Eigen::Lower>().rankUpdate(DF);
}

StatelessSolution solve_stateless(Innovation& innovation, const Eigen::Ref<const MatrixXd>& C,
                                  bool keep_all) {
  const Index k = C.cols(), q = innovation.stateless.residual.size();
  const auto nothing_seen = [&] {
    return StatelessSolution{MatrixXd(k, 0), MatrixXd::Identity(k, k), MatrixXd(0, 0), VectorXd(0),
                             MatrixXd(innovation.r.size(), 0)};
  };
  if (q == 0 || k == 0) {
    return nothing_seen();
  }
  // E C Pi = Q U: rows of U that are strong, then those that are not.
  StatelessRows rows = std::move(innovation.stateless);
  innovation.stateless = {VectorXd(0), MatrixXd(0, rows.D.cols())};
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(rows.D * C);
  const VectorXd pivots = qr.matrixR().diagonal().cwiseAbs();
  const Index p =
      std::count_if(pivots.begin(), pivots.end(), [](double pivot) { return pivot >= kWeakDirection; });
  rows.residual.applyOnTheLeft(qr.householderQ().adjoint());
  rows.D.applyOnTheLeft(qr.householderQ().adjoint());
  const Index rest = q - p;
  const bool says_something =
      rest > 0 && (rows.D.bottomRows(rest) * C).cwiseAbs().maxCoeff() > kNothing * qr.maxPivot();
  if (says_something || (keep_all && rest > 0)) {
    append(innovation, rows.D.bottomRows(rest), rows.residual.tail(rest));
  } else {
    innovation.noise.rows += rest;
    innovation.noise.squared_norm += rows.residual.tail(rest).squaredNorm();
  }
  if (p == 0) {
    return nothing_seen();
  }
  MatrixXd U = MatrixXd::Zero(p, k);
  U.triangularView<Eigen::Upper>() = qr.matrixR().topRows(p);
  U *= qr.colsPermutation().transpose();
  const Eigen::HouseholderQR<MatrixXd> right(U.transpose());  // U = L seenᵀ
  const MatrixXd basis = right.householderQ();
  StatelessSolution out;
  out.seen = basis.leftCols(p);
  out.unseen = basis.rightCols(k - p);
  out.L = MatrixXd(right.matrixQR().topRows(p).triangularView<Eigen::Upper>()).transpose();
  out.y = rows.residual.head(p);
  out.G = innovation.D * (C * out.seen);
  out.L.triangularView<Eigen::Lower>().solveInPlace<Eigen::OnTheRight>(out.G);
  innovation.r.noalias() -= out.G * out.y;
  innovation.D.noalias() -= out.G * rows.D.topRows(p);
  innovation.S.selfadjointView<Eigen::Lower>().rankUpdate(out.G);
  return out;
}

}  // namespace limber
