// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "limber/core/factors.hpp"

namespace limber::detail {

/// How the unknowns of a window's frames lie in memory, the same in each frame: pose, chain, theta. The
/// *rest* is what is not of the chain, the poses of all frames first, then their theta.
struct FrameLayout {
  Eigen::Index frames = 0;
  Eigen::Index pose = 0;
  Eigen::Index chain = 0;  ///< velocity and biases, of which no pixel tells, but the frames beside it
  Eigen::Index theta = 0;

  [[nodiscard]] Eigen::Index size() const { return pose + chain + theta; }
  /// In the rest: how long it is, and where a frame's pose and theta stand.
  [[nodiscard]] Eigen::Index rest_size() const { return frames * (pose + theta); }
  [[nodiscard]] Eigen::Index pose_in_rest(Eigen::Index frame) const { return frame * pose; }
  [[nodiscard]] Eigen::Index theta_in_rest(Eigen::Index frame) const { return frames * pose + frame * theta; }
  /// The rest's unknowns among all of them.
  [[nodiscard]] std::vector<Eigen::Index> rest() const;
  /// The chains', one frame after another.
  [[nodiscard]] std::vector<Eigen::Index> chains() const;
};

/// @brief S = L Lᵀ of the frames' normal equations, S: A, its diagonal grown by the share `damping`, minus
/// what is given of the rest. The chains go first, one frame after another: they fill no more than their own
/// rows. What is left is dense, and several times cheaper than all of S would be.
class FramesFactor {
 public:
  /// @param A the lower triangle is read. A frame's chain has to be zero in it but with chain and pose of the
  ///   same frame and of its neighbours.
  /// @param of_rest rest by rest, the lower triangle is read
  FramesFactor(const Eigen::MatrixXd& A, double damping, const Eigen::MatrixXd& of_rest,
               const FrameLayout& layout);

  /// Whether S is positive definite; else there is no solution.
  [[nodiscard]] bool succeeded() const { return dense_ && dense_->succeeded(); }
  /// S⁻¹ g.
  [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& g) const;
  /// S⁻¹, all of it.
  [[nodiscard]] Eigen::MatrixXd inverse() const;

 private:
  void factor_chain(const Eigen::MatrixXd& A, double damping, Eigen::Index frame);
  void solve_chain(Eigen::MatrixXd& X) const;
  void solve_chain_transposed(Eigen::MatrixXd& X) const;

  FrameLayout layout_;
  std::vector<Eigen::Index> rest_;
  std::vector<Cholesky> chain_;         // of L, the block of each frame's chain
  std::vector<Eigen::MatrixXd> links_;  // of L, a frame's chain by the one's before; of the first: none
  Eigen::MatrixXd Y_;                   // of L, poses by chains
  std::optional<Cholesky> dense_;       // of L, rest by rest
};

}  // namespace limber::detail
