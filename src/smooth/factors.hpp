// SPDX-License-Identifier: MIT
#pragma once

#include <ceres/cost_function.h>

#include <Eigen/Core>
#include <vector>

#include "blocks.hpp"
#include "limber/measure/stereo_model.hpp"
#include "limber/predict/motion_between.hpp"

/// The terms of the least-squares problem: whitened residuals with hand-made derivatives.
namespace limber::detail {

/// Two states and the inputs between them. Blocks: pose, motion, pose, motion (odometry: the two poses).
class MotionFactor : public ceres::CostFunction {
 public:
  /// @throws UnsolvableError if the covariance of what lies between is not positive definite
  MotionFactor(MotionBetween between, double gravity);
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override;

 private:
  MotionBetween between_;
  double gravity_;
  Eigen::MatrixXd whitener_;  // L⁻¹, Q = L Lᵀ
};

/// One pixel of one point. What its blocks are, in order: pose and the anchor's pose (unless the frame is the
/// anchor), landmark, theta (if `theta`), the parameters beyond theta (if `more`).
struct PointSight {
  const MountedCamera* camera = nullptr;  ///< kept up to date with theta and the parameters
  Landmark landmark;                      ///< chart
  Pose T_body_cam0;                       ///< of its anchor: a number
  bool in_anchor = false;
  bool theta = false, more = false;
  BodyMotion motion;  ///< at the stamp, for time offsets; in_anchor: in body axes
  Eigen::Vector2d uv, sigma_px;
};

class PointFactor : public ceres::CostFunction {
 public:
  explicit PointFactor(const PointSight& sight);
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override;

 private:
  PointSight sight_;
};

/// @brief r = A (x ⊟ x0) + b over several blocks; seven wide ones are poses, all others plain vectors.
class BlockPrior : public ceres::CostFunction {
 public:
  /// @param x0  the blocks one behind the other
  /// @param A   m×n, n the sum of the tangent sizes
  BlockPrior(std::vector<int> block_sizes, Eigen::VectorXd x0, Eigen::MatrixXd A, Eigen::VectorXd b);
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override;

 private:
  std::vector<int> sizes_;
  Eigen::VectorXd x0_;
  Eigen::MatrixXd A_;
  Eigen::VectorXd b_;
};

/// r = (b − a) / sigma over two blocks of six.
class WalkFactor : public ceres::CostFunction {
 public:
  explicit WalkFactor(const RigParameters& sigma);
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override;

 private:
  RigParameters weight_;
};

/// A with AᵀA = covariance⁻¹.
/// @throws UnsolvableError if it is not positive definite
[[nodiscard]] Eigen::MatrixXd whitener_of(const Eigen::MatrixXd& covariance);

}  // namespace limber::detail
