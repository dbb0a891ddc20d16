// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "limber/core/covariance.hpp"

namespace limber {

/// @brief Jacobian H (m×n) of a few measurements each with respect to triplets of the state: a list of blocks
/// of one to three rows (a pixel: two) and three columns. Blocks that share a place add up.
struct SparseJacobian {
  /// A dense block of columns that a row may be nonzero in.
  struct Block {
    Eigen::Index row = 0;  ///< the first
    Eigen::Index col = 0;  ///< the first of three
    /// rows×3
    Eigen::Matrix<double, Eigen::Dynamic, kTriplet, Eigen::ColMajor, kTriplet, kTriplet> value;
  };
  /// in no order
  std::vector<Block> blocks;

  /// m×n matrix, for tests and small problems.
  [[nodiscard]] Eigen::MatrixXd dense(Eigen::Index rows, Eigen::Index cols) const;
};

/// Consecutive rows that stand or fall together (one point): the unit of gating.
struct RowGroup {
  /// the first
  Eigen::Index row = 0;
  Eigen::Index rows = 0;  ///< two a camera; three once they are turned and nothing but them sees the point
  Eigen::Index own = -1;  ///< first column of the point's triplet; -1: they see no point of their own
  /// one row more, behind those of all groups (TurnedMeasurement); -1: none
  Eigen::Index fourth = -1;
};

/// @brief Whitened rows that no state moves: r = D dtheta + noise, noise ~ N(0, I). The epipolar constraints
/// of a stereo frame.
struct StatelessRows {
  Eigen::VectorXd residual;  ///< q
  Eigen::MatrixXd D;         ///< q×c
};

/// Rows that were taken out of a measurement because they are noise alone: they move nothing, but they count
/// in the NIS.
struct NoiseRows {
  /// how many were taken out
  Eigen::Index rows = 0;
  double squared_norm = 0.0;  ///< of their whitened residuals [-]
};

/// @brief A stacked measurement, linearised: r = H dx + D dtheta + noise, noise ~ N(0, diag(sigma^2)).
struct LinearMeasurement {
  Eigen::VectorXd residual;  ///< r: m
  Eigen::VectorXd sigma;     ///< standard deviations of the noise: m, positive
  SparseJacobian H;          ///< m×n
  Eigen::MatrixXd D;         ///< m×c: Jacobian with respect to the parameters that may be wrong; c = 0: none
  std::vector<RowGroup> groups;  ///< partition of the rows, in order; none once they are turned
  StatelessRows stateless;       ///< what turning set apart
  NoiseRows noise;               ///< what was taken out before

  /// m.
  [[nodiscard]] Eigen::Index rows() const { return residual.size(); }

  /// The measurement without the groups that are not `kept` (one flag per group).
  [[nodiscard]] LinearMeasurement subset(const std::vector<bool>& kept) const;
};

}  // namespace limber
