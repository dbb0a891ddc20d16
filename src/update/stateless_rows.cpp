// SPDX-License-Identifier: MIT
#include <algorithm>

#include "limber/core/factors.hpp"
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
  const SymmetricEigen eigen = symmetric_eigen(Sigma);
  return eigen.vectors * eigen.values.cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

}  // namespace

void absorb_white(Innovation& innovation, const Eigen::Ref<const MatrixXd>& Sigma) {
  // With E: q×c the stateless D and Sigma = F Fᵀ, what they leave of dtheta is F (B Bᵀ)⁻¹ Fᵀ,
  // B Bᵀ = I + Fᵀ Eᵀ E F: no difference of large numbers, however large Sigma is.
  const MatrixXd F = square_root(Sigma);
  StatelessRows& stateless = innovation.stateless;
  const MatrixXd EF = multiply(stateless.D, F);
  const Cholesky B(MatrixXd::Identity(F.cols(), F.cols()) + multiply(transposed(EF), EF));
  MatrixXd DF = multiply(innovation.D, F);
  if (stateless.residual.size() > 0) {
    innovation.r.noalias() -= DF * B.solve(EF.transpose() * stateless.residual);
    add_product(innovation.D, -1.0, DF, B.solve(multiply(transposed(EF), stateless.D)));
    const Cholesky M(MatrixXd::Identity(EF.rows(), EF.rows()) + multiply(EF, transposed(EF)));
    solve_lower(M.factor(), stateless.residual);
    solve_lower(M.factor(), stateless.D);
  }
  solve_lower_from_right(transposed(B.factor()), DF);
  add_outer(innovation.S, 1.0, DF);
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
  const PivotedQr pivoted = pivoted_qr(multiply(rows.D, C));
  const VectorXd pivots = pivoted.qr.factors.diagonal().cwiseAbs();
  const Index p =
      std::count_if(pivots.begin(), pivots.end(), [](double pivot) { return pivot >= kWeakDirection; });
  pivoted.qr.apply_Qt(rows.residual);
  pivoted.qr.apply_Qt(rows.D);
  const Index rest = q - p;
  const bool says_something = rest > 0 && multiply(rows.D.bottomRows(rest), C).cwiseAbs().maxCoeff() >
                                              kNothing * pivoted.largest_pivot;
  if (says_something || (keep_all && rest > 0)) {
    append(innovation, rows.D.bottomRows(rest), rows.residual.tail(rest));
  } else {
    innovation.noise.rows += rest;
    innovation.noise.squared_norm += rows.residual.tail(rest).squaredNorm();
  }
  if (p == 0) {
    return nothing_seen();
  }
  const HouseholderQr right = householder_qr(pivoted.turned_rows(p).transpose());  // U = L seenᵀ
  const MatrixXd basis = right.Q();
  StatelessSolution out;
  out.seen = basis.leftCols(p);
  out.unseen = basis.rightCols(k - p);
  out.L = right.R().transpose();
  out.y = rows.residual.head(p);
  out.G = multiply(innovation.D, multiply(C, out.seen));
  solve_lower_from_right(out.L, out.G);
  innovation.r.noalias() -= out.G * out.y;
  add_product(innovation.D, -1.0, out.G, rows.D.topRows(p));
  add_outer(innovation.S, 1.0, out.G);
  return out;
}

}  // namespace limber
