// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

namespace limber::detail {

/// Part of a vector, and the standard deviation of its length.
struct SurestPart {
  Eigen::VectorXd value;
  double sigma = 0.0;
};

/// @brief The part within the one, two, ... directions that are known best of which most is sure: its length
/// less five of its sigmas.
/// @param covariance  of x
[[nodiscard]] SurestPart surest_part(const Eigen::VectorXd& x, const Eigen::MatrixXd& covariance);

}  // namespace limber::detail
