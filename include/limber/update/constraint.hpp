// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "limber/update/innovation.hpp"

namespace limber {

/// Directions of D whose scaled, whitened singular value is below this move no pixel: they are left alone.
inline constexpr double kWeakDirection = 1e-3;

/// @brief Basis of the column space of D without its weak directions: D itself where no direction is weak,
/// else D times the right singular vectors whose singular value is at least kWeakDirection.
/// D: m×c, whitened and scaled; result m×rank, full column rank.
[[nodiscard]] Eigen::MatrixXd strong_directions(const Eigen::Ref<const Eigen::MatrixXd>& D);

/// T: c×rank with strong_directions(D) = D T.
[[nodiscard]] Eigen::MatrixXd strong_combinations(const Eigen::Ref<const Eigen::MatrixXd>& D);

/// @brief Takes a time-white dtheta ~ N(0, Sigma) out of an innovation: the stateless rows say what they can
/// of it, S holds what is left.
/// @param[in,out] innovation  afterwards S includes dtheta, and the rows are independent as before
/// @param         Sigma       c×c, positive semidefinite
void absorb_white(Innovation& innovation, const Eigen::Ref<const Eigen::MatrixXd>& Sigma);

/// What the stateless rows say of parameters of which nothing else is known: dtheta = C beta.
struct StatelessSolution {
  Eigen::MatrixXd seen;    ///< k×p, orthonormal: directions of beta that they see
  Eigen::MatrixXd unseen;  ///< k×(k−p), orthonormal: all others
  Eigen::MatrixXd L;       ///< p×p, lower triangular: y = L (seenᵀ beta) + noise of unit covariance
  Eigen::VectorXd y;       ///< p
  Eigen::MatrixXd G;       ///< m×p: what that noise, times −1, is to the rows of the innovation
};

/// @brief Puts what the stateless rows say of beta into the other rows: afterwards no seen direction moves
/// them, r −= G y and S += G Gᵀ, and what else moves the rows, D, is as it is then. Stateless rows that say
/// nothing become noise rows.
/// @param C         c×k, scaled to one plausible error a column
/// @param keep_all  rows that say nothing of beta join the others nevertheless: they may say something of
/// what
///                  C leaves out
[[nodiscard]] StatelessSolution solve_stateless(Innovation& innovation,
                                                const Eigen::Ref<const Eigen::MatrixXd>& C,
                                                bool keep_all = false);

}  // namespace limber
