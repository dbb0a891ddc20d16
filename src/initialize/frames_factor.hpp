// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "limber/core/factors.hpp"

namespace limber::detail {

/// How the unknowns of a window's frames lie in memory, the same in each frame: pose, chain, theta.
struct FrameLayout {
  Eigen::Index frames = 0;
  Eigen::Index pose = 0;
  Eigen::Index chain = 0;  ///< velocity and biases, of which no pixel tells, but the frames beside it
  Eigen::Index theta = 0;

  [[nodiscard]] Eigen::Index size() const { return pose + chain + theta; }
};

/// @brief S = L Lᵀ of the frames' normal equations, points eliminated. The chains go first, one frame after
/// another: they fill no more than their own rows. What is left is dense, and several times cheaper than all
/// of S would be.
class FramesFactor {
 public:
  /// @param S the lower triangle is read. A frame's chain has to be zero in it but with chain and pose of the
  ///   same frame and of its neighbours.
  FramesFactor(const Eigen::MatrixXd& S, const FrameLayout& layout);

  /// Whether S is positive definite; else there is no solution.
  [[nodiscard]] bool succeeded() const { return dense_ && dense_->succeeded(); }
  /// S⁻¹ g.
  [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& g) const;

 private:
  void factor_chain(const Eigen::MatrixXd& S, Eigen::Index frame);

  FrameLayout layout_;
  std::vector<Eigen::Index> rest_;  // unknowns that are not of the chain: poses first, then theta
  std::vector<Cholesky> chain_;     // of L, the block of each frame's chain
  std::vector<Eigen::MatrixXd>
      links_;                      // of L, chain of a frame by chain of the one before; of the first: none
  Eigen::MatrixXd Y_;              // of L, poses by chains
  std::optional<Cholesky> dense_;  // of L, rest by rest
};

}  // namespace limber::detail
