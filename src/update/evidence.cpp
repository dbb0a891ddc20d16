// SPDX-License-Identifier: MIT
#include "limber/update/evidence.hpp"

#include <Eigen/LU>

#include "limber/core/factors.hpp"

namespace limber {

EvidenceStatistic statistic(const ParameterEvidence& evidence, double weakest) {
  EvidenceStatistic out;
  if (evidence.empty()) {
    return out;
  }
  const SymmetricEigen eigen = symmetric_eigen(evidence.information);
  for (Eigen::Index k = 0; k < eigen.values.size(); ++k) {
    if (eigen.values(k) >= weakest) {
      const double component = eigen.vectors.col(k).dot(evidence.vector);
      out.value += component * component / eigen.values(k);
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
                                                multiply(evidence.information, Sigma));
  const Eigen::MatrixXd information = lu.solve(evidence.information);
  return {symmetric_part(information), lu.solve(evidence.vector)};
}

}  // namespace limber
