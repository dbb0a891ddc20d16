// SPDX-License-Identifier: MIT
#include "limber/update/update.hpp"

#include <Eigen/Cholesky>
#include <stdexcept>
#include <string>
#include <utility>

#include "limber/core/factors.hpp"
#include "limber/update/constraint.hpp"
#include "limber/update/frame_innovation.hpp"
#include "limber/update/null_space_projection.hpp"
#include "limber/update/whiten.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

void check(const Innovation& innovation, const ParameterErrorModel& model) {
  const Index c = innovation.D.cols();
  if ((model.constrained.cols() > 0 && model.constrained.rows() != c) ||
      (model.white_covariance.size() > 0 && model.white_covariance.rows() != c)) {
    throw std::invalid_argument("update: D has " + std::to_string(c) + " columns, but C has " +
                                std::to_string(model.constrained.rows()) + " rows and Sigma_w " +
                                std::to_string(model.white_covariance.rows()));
  }
  if (model.nuisance < 0 || model.nuisance > model.constrained.cols() ||
      (model.watched.cols() > 0 && model.constrained.cols() > model.nuisance &&
       model.watched.cols() != model.constrained.cols() - model.nuisance)) {
    throw std::invalid_argument("update: of " + std::to_string(model.constrained.cols()) +
                                " constrained columns " + std::to_string(model.nuisance) +
                                " are nuisance, but " + std::to_string(model.watched.cols()) +
                                " are watched");
  }
}

/// NaN on the diagonal of a factor passes for a success.
bool is_positive_definite(const Cholesky& cholesky) {
  return cholesky.succeeded() && cholesky.factor().diagonal().allFinite();
}

UpdateReport untouched(UpdateStatus status, Index n) {
  UpdateReport report;
  report.status = status;
  report.dx = VectorXd::Zero(n);
  return report;
}

/// With S = L Lᵀ: the rows of an innovation, whitened and turned such that the constrained ones come first.
struct WhiteRows {
  VectorXd y;             ///< m: Qᵀ L⁻¹ r
  MatrixXd W;             ///< n×m: P Hᵀ L⁻ᵀ Q
  Index constrained = 0;  ///< how many rows the constraint takes

  [[nodiscard]] Index used() const { return y.size() - constrained; }
};

/// What the constraint leaves of the stateless rows and takes of the others: y = F beta + eps, eps ~ N(0, I).
struct ConstrainedRows {
  VectorXd y;
  MatrixXd F;
  MatrixXd W;  ///< covariance of the states' errors with eps; empty unless asked for
};

/// @param D_unseen  D C of what the stateless rows do not see: m×(k−p)
/// @param L         of S
ConstrainedRows constrained_rows(const WhiteRows& rows, const StatelessSolution& stateless,
                                 const MatrixXd& D_unseen, const MatrixXd& L,
                                 const NullSpaceProjection& projection, bool with_W) {
  const Index p = stateless.y.size(), q = rows.constrained;
  MatrixXd turned(rows.y.size(), D_unseen.cols() + p);  // Qᵀ L⁻¹ [D_unseen, G]
  turned << D_unseen, stateless.G;
  solve_lower(L, turned);
  projection.apply_left(turned);
  const auto A = turned.rightCols(p);
  const auto A_used = A.bottomRows(rows.used());
  // The noise of the stateless rows is −G to the others: what those tell of it is taken out.
  ConstrainedRows out{VectorXd(p + q), MatrixXd(p + q, turned.cols()), MatrixXd(0, 0)};
  out.y << stateless.y + A_used.transpose() * rows.y.tail(rows.used()), rows.y.head(q);
  out.F << multiply(stateless.L, transposed(stateless.seen)),
      multiply(turned.topLeftCorner(q, D_unseen.cols()), transposed(stateless.unseen));
  MatrixXd Omega = MatrixXd::Identity(p + q, p + q);
  add_product(Omega.topLeftCorner(p, p), -1.0, transposed(A_used), A_used);
  Omega.bottomLeftCorner(q, p) = -A.topRows(q);
  if (p + q == 0) {
    return out;
  }
  const Cholesky root(std::move(Omega));
  solve_lower(root.factor(), out.y);
  solve_lower(root.factor(), out.F);
  if (with_W) {
    out.W.resize(rows.W.rows(), p + q);
    out.W.leftCols(p) = multiply(rows.W.rightCols(rows.used()), A_used);
    out.W.rightCols(q) = rows.W.leftCols(q);
    solve_lower_from_right(transposed(root.factor()), out.W);
  }
  return out;
}

/// What the unused rows say whatever the last `nuisance` columns of F are multiplied with.
void project_out(ConstrainedRows& rows, Index nuisance) {
  const NullSpaceProjection projection(strong_directions(rows.F.rightCols(nuisance)));
  const Index left = rows.y.size() - projection.rank();
  projection.apply_left(rows.y);
  projection.apply_left(rows.F);
  rows.y = rows.y.tail(left).eval();
  rows.F = rows.F.bottomLeftCorner(left, rows.F.cols() - nuisance).eval();
  if (rows.W.size() > 0) {
    projection.apply_right(rows.W);
    rows.W = rows.W.rightCols(left).eval();
  }
}

/// Evidence about a beta that is not constrained: (D B)ᵀ S⁻¹ (D B) and (D B)ᵀ S⁻¹ r of the rows that are
/// used, and of the stateless ones as well.
ParameterEvidence evidence_of(const Innovation& innovation, const MatrixXd& B, const WhiteRows& rows,
                              const MatrixXd& L, const NullSpaceProjection& projection) {
  MatrixXd DB = multiply(innovation.D, B);
  solve_lower(L, DB);
  projection.apply_left(DB);
  const auto used = DB.bottomRows(rows.used());
  const MatrixXd EB = multiply(innovation.stateless.D, B);
  return {multiply(transposed(used), used) + multiply(transposed(EB), EB),
          used.transpose() * rows.y.tail(rows.used()) + EB.transpose() * innovation.stateless.residual};
}

}  // namespace

UpdateReport update(Covariance& P, const LinearMeasurement& measurement, const ParameterErrorModel& model) {
  return update(P, compressed(form_frame_innovation(P, measurement)), model);
}

UpdateReport update(Covariance& P, Innovation&& innovation, const ParameterErrorModel& model) {
  check(innovation, model);
  if (innovation.r.size() == 0) {
    return untouched(UpdateStatus::kEmpty, P.size());
  }
  if (model.white_covariance.size() > 0) {
    absorb_white(innovation, model.white_covariance);
  }
  const MatrixXd& C = model.constrained;
  const bool watches_another = model.watched.cols() > 0 && C.cols() == model.nuisance;
  const StatelessSolution stateless = solve_stateless(innovation, C, watches_another);
  const MatrixXd D_unseen =
      C.cols() > 0 ? multiply(innovation.D, multiply(C, stateless.unseen)) : MatrixXd(innovation.r.size(), 0);
  MatrixXd A = strong_directions(D_unseen);
  if (A.cols() == innovation.r.size()) {
    return untouched(UpdateStatus::kEmpty, P.size());
  }

  const Cholesky S(std::move(innovation.S));
  if (!is_positive_definite(S)) {
    return untouched(UpdateStatus::kSingularInnovation, P.size());
  }
  const MatrixXd& L = S.factor();
  WhiteRows rows{std::move(innovation.r), std::move(innovation.PHt), A.cols()};
  solve_lower(L, rows.y);
  whiten_columns(L, rows.W);
  solve_lower(L, A);
  const NullSpaceProjection projection(A);
  projection.apply_left(rows.y);
  projection.apply_right(rows.W);

  const auto y_used = rows.y.tail(rows.used());
  const auto W_used = rows.W.rightCols(rows.used());
  UpdateReport report;
  report.status = UpdateStatus::kUpdated;
  report.dx.noalias() = W_used * y_used;
  report.nis =
      y_used.squaredNorm() + innovation.stateless.residual.squaredNorm() + innovation.noise.squared_norm;
  report.dof = rows.used() + innovation.stateless.residual.size() + innovation.noise.rows;
  report.rank = stateless.y.size() + rows.constrained;
  P.subtract_outer(W_used);
  if (model.watched.cols() == 0) {
    return report;
  }
  if (watches_another) {
    report.evidence = evidence_of(innovation, model.watched, rows, L, projection);
    return report;
  }
  ConstrainedRows lost =
      constrained_rows(rows, stateless, D_unseen, L, projection, model.witness.has_value());
  if (model.nuisance > 0) {
    project_out(lost, model.nuisance);
  }
  report.evidence = {multiply(transposed(lost.F), lost.F), lost.F.transpose() * lost.y};
  if (model.witness && lost.y.size() > 0) {
    auto own = report.dx.segment<kWitnessSize>(model.witness->at);
    own += learn(P, model.witness->at, model.witness->mean + own, {lost.y, lost.F, lost.W});
  }
  return report;
}

UpdateReport update_gain_form(Covariance& P, const LinearMeasurement& measurement,
                              const ParameterErrorModel& model) {
  const Innovation innovation = form_innovation(P, measurement);
  check(innovation, model);
  if (measurement.stateless.residual.size() > 0) {
    throw std::invalid_argument("update_gain_form: expected a measurement as it is, not a compressed one");
  }
  const Index n = P.size();
  if (innovation.r.size() == 0) {
    return untouched(UpdateStatus::kEmpty, n);
  }
  MatrixXd with_white = innovation.S;
  if (model.white_covariance.size() > 0) {
    with_white += congruence(innovation.D, model.white_covariance);
  }
  const Cholesky S(std::move(with_white));
  if (!is_positive_definite(S)) {
    return untouched(UpdateStatus::kSingularInnovation, n);
  }
  const MatrixXd K = S.solve(innovation.PHt.transpose()).transpose();  // P Hᵀ S⁻¹
  MatrixXd gain = K;
  MatrixXd P_new = P.dense();  // (I − K H) P
  add_product(P_new, -1.0, K, transposed(innovation.PHt));
  Index rank = 0;
  double nis = innovation.r.dot(S.solve(innovation.r));
  if (model.constrained.cols() > 0) {
    const MatrixXd dH = multiply(innovation.D, model.constrained);
    const MatrixXd SinvD = S.solve(dH);
    const Eigen::LDLT<MatrixXd> M(multiply(transposed(dH), SinvD));
    if (M.info() != Eigen::Success || !M.isPositive() || M.vectorD().minCoeff() <= 0.0) {
      return untouched(UpdateStatus::kSingularInnovation, n);
    }
    const MatrixXd KD = multiply(K, dH);
    add_product(gain, -1.0, KD, M.solve(SinvD.transpose()));  // Eq. (17)
    add_product(P_new, 1.0, KD, M.solve(KD.transpose()));     // Eq. (19)
    const VectorXd d = SinvD.transpose() * innovation.r;
    nis -= d.dot(M.solve(d));
    rank = dH.cols();
  }
  P.set_diagonal_block(0, symmetric_part(P_new));
  UpdateReport report;
  report.status = UpdateStatus::kUpdated;
  report.dx = gain * innovation.r;
  report.nis = nis + innovation.noise.squared_norm;
  report.dof = innovation.r.size() - rank + innovation.noise.rows;
  report.rank = rank;
  return report;
}

}  // namespace limber
