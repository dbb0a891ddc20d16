// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "limber/update/white_groups.hpp"

namespace limber {

/// What most groups of a measurement agree upon.
struct Consensus {
  Eigen::VectorXd beta;          ///< k: the shared offset, in prior standard deviations
  std::vector<double> distance;  ///< squared Mahalanobis distance of each group from it [-], one per group
};

/// @brief Robust fit of a shared offset: r_g = A_g beta + e_g, e_g ~ N(0, I), beta ~ N(0, I), by least sum of
/// distances (iteratively reweighted), refined with weights that fall with the square. Up to some 40 % of
/// gross outliers do not move it. What groups share beside A is ignored: good for telling gross outliers, not
/// for statistics. O(m k²).
/// @param white  rows and A, k may be zero; each group has its own S
/// @param scale  A is multiplied by it
[[nodiscard]] Consensus find_consensus(const WhiteGroups& white, double scale);

}  // namespace limber
