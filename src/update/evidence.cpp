// SPDX-License-Identifier: MIT
#include "limber/update/evidence.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace limber {

EvidenceStatistic statistic(const ParameterEvidence& evidence, double weakest) {
  EvidenceStatistic out;
  if (evidence.empty()) {
    return out;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(evidence.information);
  for (Eigen::Index k = 0; k < eigen.eigenvalues().size(); ++k) {
    if (eigen.eigenvalues()(k) >= weakest) {
      const double component = eigen.eigenvectors().col(k).dot(evidence.vector);
      out.value += component * component / eigen.eigenvalues()(k);
      ++out.dof;
    }
  }
  return out;
}

ParameterEvidence without_white(const ParameterEvidence& evidence,
                                const Eigen::Ref<const Eigen::MatrixXd>& Sigma) {
  // With M = (DB)ᵀ S⁻¹ (DB) it was M' = (M⁻¹ + Sigma)⁻¹: M = (I − M' Sigma)⁻¹ M', and the vector alike.
  const Eigen::Index k = Sigma.rows();
  const Eigen::PartialPivLU<Eigen::MatrixXd> lu(Eigen::MatrixXd::Identity(k, k) -
                                                evidence.information * Sigma);
  const Eigen::MatrixXd information = lu.solve(evidence.information);
  return {0.5 * (information + information.transpose()), lu.solve(evidence.vector)};
}

}  // namespace limber
