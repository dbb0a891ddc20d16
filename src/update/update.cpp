// SPDX-License-Identifier: MIT
#include "limber/update/update.hpp"

#include <Eigen/Cholesky>
#include <stdexcept>
#include <string>
#include <utility>

#include "limber/update/constraint.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

void check(const Innovation& innovation, const ParameterTreatment& treatment) {
  const Index c = innovation.D.cols();
  if ((treatment.constrained.cols() > 0 && treatment.constrained.rows() != c) ||
      (treatment.white_covariance.size() > 0 && treatment.white_covariance.rows() != c)) {
    throw std::invalid_argument("update: D has " + std::to_string(c) + " columns, but C has " +
                                std::to_string(treatment.constrained.rows()) + " rows and Sigma_w " +
                                std::to_string(treatment.white_covariance.rows()));
  }
}

/// S += D Sigma_w Dᵀ.
void add_white_covariance(Innovation& innovation, const ParameterTreatment& treatment) {
  if (treatment.white_covariance.size() > 0) {
    innovation.S.noalias() += innovation.D * (treatment.white_covariance * innovation.D.transpose()).eval();
  }
}

/// Eigen calls a factor with NaN on its diagonal a success.
template <typename Matrix>
bool is_positive_definite(const Eigen::LLT<Matrix>& llt) {
  return llt.info() == Eigen::Success && llt.matrixLLT().diagonal().allFinite();
}

UpdateReport untouched(UpdateStatus status, Index n) {
  UpdateReport report;
  report.status = status;
  report.dx = VectorXd::Zero(n);
  return report;
}

}  // namespace

UpdateReport update(Covariance& P, const LinearMeasurement& measurement,
                    const ParameterTreatment& treatment) {
  return update(P, form_innovation(P, measurement), treatment);
}

UpdateReport update(Covariance& P, Innovation&& innovation, const ParameterTreatment& treatment) {
  check(innovation, treatment);
  const Index m = innovation.r.size();
  if (m == 0) {
    return untouched(UpdateStatus::kEmpty, P.size());
  }
  add_white_covariance(innovation, treatment);

  const bool watches = treatment.watched.cols() > 0;
  MatrixXd DB = watches ? MatrixXd(innovation.D * treatment.watched) : MatrixXd(m, 0);
  Index rank = 0;
  if (treatment.constrained.cols() > 0) {
    const NullSpaceProjection projection(innovation.D * treatment.constrained);
    rank = projection.rank();
    projection.apply_left(innovation.r);
    projection.apply_left(DB);
    projection.apply_right(innovation.PHt);
    projection.apply_both(innovation.S);
  }
  const Index dof = m - rank;
  if (dof == 0) {
    return untouched(UpdateStatus::kEmpty, P.size());
  }

  // The rows that the constraint takes away stand last: whoever watches them factorises them as well.
  const Index rows = watches ? m : dof;
  Eigen::Ref<MatrixXd> S = innovation.S.topLeftCorner(rows, rows);
  const Eigen::LLT<Eigen::Ref<MatrixXd>> llt(S);  // in place
  if (!is_positive_definite(llt)) {
    return untouched(UpdateStatus::kSingularInnovation, P.size());
  }
  // With S = L Lᵀ: W = P Hᵀ L⁻ᵀ, dx = W L⁻¹ r, P -= W Wᵀ.
  const VectorXd y = llt.matrixL().solve(innovation.r.head(rows));
  auto W = innovation.PHt.leftCols(rows);
  llt.matrixL().transpose().solveInPlace<Eigen::OnTheRight>(W);
  UpdateReport report;
  report.status = UpdateStatus::kUpdated;
  report.dx.noalias() = W.leftCols(dof) * y.head(dof);
  report.nis = y.head(dof).squaredNorm() + innovation.noise.squared_norm;
  report.dof = dof + innovation.noise.rows;
  report.rank = rank;
  P.subtract_outer(W.leftCols(dof));
  if (watches) {
    llt.matrixL().solveInPlace(DB);
    report.evidence = {DB.transpose() * DB, DB.transpose() * y};
  }
  if (treatment.witness && rank > 0) {
    auto own = report.dx.segment<kWitnessSize>(treatment.witness->at);
    own += learn(P, treatment.witness->at, treatment.witness->mean + own,
                 {y.tail(rank), DB.bottomRows(rank), W.rightCols(rank)});
  }
  return report;
}

UpdateReport update_gain_form(Covariance& P, const LinearMeasurement& measurement,
                              const ParameterTreatment& treatment) {
  Innovation innovation = form_innovation(P, measurement);
  check(innovation, treatment);
  const Index n = P.size();
  if (innovation.r.size() == 0) {
    return untouched(UpdateStatus::kEmpty, n);
  }
  add_white_covariance(innovation, treatment);
  const Eigen::LLT<MatrixXd> S(innovation.S);
  if (!is_positive_definite(S)) {
    return untouched(UpdateStatus::kSingularInnovation, n);
  }
  const MatrixXd K = S.solve(innovation.PHt.transpose()).transpose();  // P Hᵀ S⁻¹
  MatrixXd L = K;
  MatrixXd P_new = P.dense() - K * innovation.PHt.transpose();  // (I − K H) P
  Index rank = 0;
  double nis = innovation.r.dot(S.solve(innovation.r));
  if (treatment.constrained.cols() > 0) {
    const MatrixXd dH = innovation.D * treatment.constrained;
    const MatrixXd SinvD = S.solve(dH);
    const Eigen::LDLT<MatrixXd> M(dH.transpose() * SinvD);
    if (M.info() != Eigen::Success || !M.isPositive() || M.vectorD().minCoeff() <= 0.0) {
      return untouched(UpdateStatus::kSingularInnovation, n);
    }
    const MatrixXd KD = K * dH;
    L -= KD * M.solve(SinvD.transpose());   // Eq. (17)
    P_new += KD * M.solve(KD.transpose());  // Eq. (19)
    const VectorXd d = SinvD.transpose() * innovation.r;
    nis -= d.dot(M.solve(d));
    rank = dH.cols();
  }
  P.set_diagonal_block(0, 0.5 * (P_new + P_new.transpose()));
  UpdateReport report;
  report.status = UpdateStatus::kUpdated;
  report.dx = L * innovation.r;
  report.nis = nis + innovation.noise.squared_norm;
  report.dof = innovation.r.size() - rank + innovation.noise.rows;
  report.rank = rank;
  return report;
}

}  // namespace limber
