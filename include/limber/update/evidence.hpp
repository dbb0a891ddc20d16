// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

namespace limber {

/// @brief What measurements say about parameters beta that were taken for zero, in information form:
/// beta_hat = information⁻¹ vector, Cov(beta_hat) = information⁻¹. With r = H dx + D B beta + noise and
/// S = H P Hᵀ + R: information = (D B)ᵀ S⁻¹ (D B), vector = (D B)ᵀ S⁻¹ r. Evidence of independent innovations
/// adds up.
struct ParameterEvidence {
  Eigen::MatrixXd information;  ///< k×k
  Eigen::VectorXd vector;       ///< k

  /// Nothing was seen.
  [[nodiscard]] bool empty() const { return vector.size() == 0; }
};

/// vectorᵀ information⁺ vector, chi-square of `dof` degrees if beta is zero.
struct EvidenceStatistic {
  /// chi-square with `dof`
  double value = 0.0;
  Eigen::Index dof = 0;  ///< directions of beta that the evidence can see
};

/// @param weakest  directions with less information than this, one over the variance of beta, do not count
[[nodiscard]] EvidenceStatistic statistic(const ParameterEvidence& evidence, double weakest);

/// @brief The same evidence as if S had not held the share D Sigma_w Dᵀ of a time-white beta.
/// @param Sigma  k×k, covariance of beta that was part of S
[[nodiscard]] ParameterEvidence without_white(const ParameterEvidence& evidence,
                                              const Eigen::Ref<const Eigen::MatrixXd>& Sigma);

}  // namespace limber
