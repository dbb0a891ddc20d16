// SPDX-License-Identifier: MIT
#include "limber/update/evidence.hpp"

#include <Eigen/Eigenvalues>

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

}  // namespace limber
