// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "window_problem.hpp"

namespace limber::detail {

/// The points of a window's normal equations, eliminated: of each, V damped by a share of its diagonal. The
/// equations have to outlive it.
class PointsElimination {
 public:
  PointsElimination(const WindowNormal& normal, double damping);

  /// @brief W V⁻¹ Wᵀ, the lower triangle: what goes from the frames' matrix, rest by rest. A point fills only
  /// the rows of the frames from its first sighting to its last, so points go in groups that begin alike.
  [[nodiscard]] Eigen::MatrixXd from_matrix() const;
  /// W V⁻¹ g_points: what goes from the frames' gradient.
  [[nodiscard]] Eigen::VectorXd from_gradient() const;
  /// V⁻¹ g_points: the points' step while the frames stay.
  [[nodiscard]] Eigen::VectorXd step_alone() const;
  /// The points' step that goes with that of the frames' rest.
  [[nodiscard]] Eigen::VectorXd step(const Eigen::VectorXd& rest) const;

 private:
  /// V⁻¹ x, point by point.
  [[nodiscard]] Eigen::VectorXd times_inverse(Eigen::VectorXd x) const;
  void add_group(const std::vector<std::size_t>& points, Eigen::MatrixXd& out) const;

  const WindowNormal& normal_;
  std::vector<Eigen::Matrix3d> inverse_;
};

}  // namespace limber::detail
