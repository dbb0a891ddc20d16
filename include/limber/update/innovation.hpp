// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "limber/core/covariance.hpp"
#include "limber/core/linear_measurement.hpp"

namespace limber {

/// @brief The measurement in units of its noise, and what the prior says about it.
/// All rows are divided by sigma, so that the noise is the identity.
struct Innovation {
  Eigen::VectorXd r;        ///< m
  Eigen::MatrixXd D;        ///< m×c
  Eigen::MatrixXd PHt;      ///< P Hᵀ: n×m
  Eigen::MatrixXd S;        ///< H P Hᵀ + I: m×m, full symmetric
  StatelessRows stateless;  ///< the measurement's
  NoiseRows noise;          ///< the measurement's
};

/// @throws std::invalid_argument if shapes disagree, groups are no partition of the rows, a sigma is not
/// positive or a number is not finite
void check(const Covariance& P, const LinearMeasurement& measurement);

/// @brief Whitens the measurement and forms P Hᵀ and S from the sparse H. O(n m) with the few blocks a row
/// has.
/// @throws std::invalid_argument as check
[[nodiscard]] Innovation form_innovation(const Covariance& P, const LinearMeasurement& measurement);

}  // namespace limber
