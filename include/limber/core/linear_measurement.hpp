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

}  // namespace limber
