// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "limber/core/covariance.hpp"

namespace limber {

/// Number of scalar states of a witness, whether or not all of them are watched.
inline constexpr Eigen::Index kWitnessSize = 6;

/// @brief A constant beta that learns and never teaches: the mirror of a Schmidt (consider) parameter.
///
/// The constrained gain leaves the rows that the parameters touch unused. The witness takes them, with the
/// optimal gain and the full cross-covariance to all states, so that its estimate is consistent however much
/// successive frames share the errors of pose and map; no other state hears of it.
struct Witness {
  Eigen::Index at = 0;                          ///< start of its block in the state
  Eigen::Matrix<double, kWitnessSize, 1> mean;  ///< before the update
};

/// Rows that the constraint took out of an update: y = F beta + eps, eps ~ N(0, I), independent of the rows
/// that were used, and correlated with the states as W says.
struct UnusedRows {
  Eigen::Ref<const Eigen::VectorXd> y;  ///< rank
  Eigen::Ref<const Eigen::MatrixXd> F;  ///< rank × k, k <= kWitnessSize
  Eigen::Ref<const Eigen::MatrixXd> W;  ///< n × rank: covariance of the states' errors with eps
};

/// @brief Lets the witness learn from unused rows; P is that after the update with the used ones.
/// @param mean  the witness's mean after that update
/// @return correction of the mean. Of P only the witness's rows and columns change.
/// @note docs/derivations/witness.md
[[nodiscard]] Eigen::VectorXd learn(Covariance& P, Eigen::Index at,
                                    const Eigen::Ref<const Eigen::VectorXd>& mean, const UnusedRows& rows);

}  // namespace limber
