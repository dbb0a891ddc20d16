// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "limber/core/covariance.hpp"

namespace limber {

/// @brief Jacobian H (m×n) of pairs of measurements with respect to triplets of the state: a list of 2×3
/// blocks. Blocks that share a place add up.
struct SparseJacobian {
  struct Block {
    Eigen::Index row = 0;  ///< first of two rows
    Eigen::Index col = 0;  ///< first of three columns
    Eigen::Matrix<double, 2, 3> value;
  };
  std::vector<Block> blocks;

  /// m×n matrix, for tests and small problems.
  [[nodiscard]] Eigen::MatrixXd dense(Eigen::Index rows, Eigen::Index cols) const;
};

/// Consecutive rows that stand or fall together (one point): the unit of gating.
struct RowGroup {
  Eigen::Index row = 0;
  Eigen::Index rows = 0;  ///< even
};

/// @brief A stacked measurement, linearised: r = H dx + D dtheta + noise, noise ~ N(0, diag(sigma^2)).
struct LinearMeasurement {
  Eigen::VectorXd residual;  ///< r: m
  Eigen::VectorXd sigma;     ///< standard deviations of the noise: m, positive
  SparseJacobian H;          ///< m×n
  Eigen::MatrixXd D;         ///< m×c: Jacobian with respect to the parameters that may be wrong; c = 0: none
  std::vector<RowGroup> groups;  ///< partition of the rows, in order

  [[nodiscard]] Eigen::Index rows() const { return residual.size(); }

  /// The measurement without the groups that are not `kept` (one flag per group).
  [[nodiscard]] LinearMeasurement subset(const std::vector<bool>& kept) const;
};

/// @brief The measurement in units of its noise, and what the prior says about it.
/// All rows are divided by sigma, so that the noise is the identity.
struct Innovation {
  Eigen::VectorXd r;    ///< m
  Eigen::MatrixXd D;    ///< m×c
  Eigen::MatrixXd PHt;  ///< P Hᵀ: n×m
  Eigen::MatrixXd S;    ///< H P Hᵀ + I: m×m, full symmetric
};

/// @brief Whitens the measurement and forms P Hᵀ and S from the sparse H. O(n m) with the few blocks a row
/// has.
/// @throws std::invalid_argument if shapes disagree, a sigma is not positive or a residual is not finite
[[nodiscard]] Innovation form_innovation(const Covariance& P, const LinearMeasurement& measurement);

}  // namespace limber
