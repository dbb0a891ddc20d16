// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "limber/core/covariance.hpp"
#include "limber/update/evidence.hpp"
#include "limber/update/innovation.hpp"
#include "limber/update/witness.hpp"

namespace limber {

/// What the update did. Unless it is kUpdated, the covariance is exactly as it was and dx is zero.
enum class UpdateStatus : std::uint8_t {
  kUpdated,
  kEmpty,              ///< no rows, or none left beside the constraints
  kSingularInnovation  ///< S is not positive definite: the covariance was broken before
};

/// How a wrong parameter theta may act on the measurement r = H dx + D dtheta + noise.
struct ParameterErrorModel {
  /// C: c×k. The gain obeys L D C = 0. Columns are scaled to one plausible error each (0.1 deg, 5 % of the
  /// baseline); k = 0: no constraint. Any rank.
  Eigen::MatrixXd constrained;
  /// Sigma_w: c×c, covariance of dtheta, fresh in every measurement (time-white). Empty: none.
  Eigen::MatrixXd white_covariance{};
  /// B: c×k, what is watched: dtheta = B beta; the report then holds the evidence about beta. Columns are
  /// scaled like C: they are those of C that come before the nuisance, or, where C is nuisance alone, any
  /// that are not among them. k = 0: nothing.
  Eigen::MatrixXd watched{};
  /// The last columns of C: constrained, and of no interest. What is said of beta is true whatever they are.
  Eigen::Index nuisance = 0;
  /// A state that learns beta from the rows which the constraint takes from all others; needs `watched`.
  std::optional<Witness> witness{};
};

/// Outcome of an update.
struct UpdateReport {
  /// what became of the estimate
  UpdateStatus status = UpdateStatus::kEmpty;
  Eigen::VectorXd dx;     ///< correction of the error state: n
  double nis = 0.0;       ///< normalised innovation squared of the projected rows [-]
  Eigen::Index dof = 0;   ///< its degrees of freedom: m − rank(D C), m with the measurement's noise rows
  Eigen::Index rank = 0;  ///< rank of D C
  ParameterEvidence evidence;  ///< about beta; empty unless something is watched
};

/// @brief EKF update with the least-variance gain among those that obey L D C = 0 (null-space form).
///
/// The gain is, with \f$ A = D C \f$, \f$ S = H P H^T + R \f$ and \f$ K = P H^T S^{-1} \f$,
/// \f[ L = K - K A (A^T S^{-1} A)^{-1} A^T S^{-1}, \qquad
/// P^+ = (I - K H) P + K A (A^T S^{-1} A)^{-1} (K A)^T . \f]
/// With N a basis of the left null space of D C it is the ordinary EKF on Nᵀr, NᵀH, NᵀRN: m − rank(D C) rows,
/// P stays symmetric positive definite. No constraint and no white covariance: the plain EKF. Rows that say
/// nothing are taken out first (`compressed`), and what no state moves (the epipolar constraints) is solved
/// for theta before the rest is projected.
/// @param[in,out] P           n×n
/// @param[in]     measurement r: m; H: m×n; sigma: m; D: m×c
/// @throws std::invalid_argument if shapes disagree; the message gives them
/// @note [Vivet2022], Eqs. (16)-(19) as corrected; derivation in docs/derivations/constrained-update.md. O(n²
/// m).
[[nodiscard]] UpdateReport update(Covariance& P, const LinearMeasurement& measurement,
                                  const ParameterErrorModel& model);

/// The same, from an innovation that was already formed; consumes it. Row for row, as it comes.
[[nodiscard]] UpdateReport update(Covariance& P, Innovation&& innovation, const ParameterErrorModel& model);

/// @brief The same update in the gain form of the paper: L = K − K D (DᵀS⁻¹D)⁻¹ DᵀS⁻¹, Eq. (17) and (19)
/// corrected. Dense and slow; singular where D C is rank-deficient (status kSingularInnovation). The
/// reference of the tests.
[[nodiscard]] UpdateReport update_gain_form(Covariance& P, const LinearMeasurement& measurement,
                                            const ParameterErrorModel& model);

}  // namespace limber
