// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "limber/core/linear_measurement.hpp"

namespace limber {

/// What most groups of a measurement agree upon.
struct Consensus {
  Eigen::VectorXd beta;          ///< k: the shared offset, in prior standard deviations
  std::vector<double> distance;  ///< squared Mahalanobis distance of each group from it [-], one per group
};

/// @brief Robust fit of a shared offset: r_g = A_g beta + e_g, Cov(e_g) = S_gg, beta ~ N(0, I), by least sum
/// of distances (iteratively reweighted), refined with weights that fall with the square. Up to some 40 % of
/// gross outliers do not move it. What groups share through S beside A is ignored: good for telling gross
/// outliers, not for statistics. O(m k²).
/// @param r       m: residual
/// @param S       m×m, of which the groups' diagonal blocks are read
/// @param groups  partition of the rows
/// @param A       m×k, k may be zero
[[nodiscard]] Consensus find_consensus(const Eigen::VectorXd& r, const Eigen::MatrixXd& S,
                                       const std::vector<RowGroup>& groups, const Eigen::MatrixXd& A);

}  // namespace limber
