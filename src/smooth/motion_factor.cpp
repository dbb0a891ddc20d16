// SPDX-License-Identifier: MIT
#include <stdexcept>

#include "factors.hpp"

#include "limber/core/factors.hpp"
#include "limber/smooth/unsolvable_error.hpp"

namespace limber::detail {

using Eigen::Index;
using Eigen::MatrixXd;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

MatrixXd whitener_of(const MatrixXd& covariance) {
  // Scaled to unit diagonal first: units differ by many orders of magnitude.
  const Eigen::VectorXd scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
  const Cholesky cholesky(scale.asDiagonal() * covariance * scale.asDiagonal());
  if (!scale.allFinite() || !cholesky.succeeded()) {
    throw UnsolvableError("smoother: a covariance is not positive definite");
  }
  MatrixXd whitener = scale.asDiagonal();
  solve_lower(cholesky.factor(), whitener);
  return whitener;
}

MotionFactor::MotionFactor(MotionBetween between, double gravity)
    : between_(std::move(between)), gravity_(gravity), whitener_(whitener_of(between_.Q)) {
  const int extra = motion_size(between_.motion);
  set_num_residuals(static_cast<int>(between_.Q.rows()));
  for (int side = 0; side < 2; ++side) {
    mutable_parameter_block_sizes()->push_back(kPoseBlock);
    if (extra > 0) {
      mutable_parameter_block_sizes()->push_back(extra);
    }
  }
}

bool MotionFactor::Evaluate(double const* const* blocks, double* residuals, double** jacobians) const {
  const bool has_motion = between_.motion != MotionModel::kOdometry;
  const int to = has_motion ? 2 : 1;
  const MotionError e =
      motion_error(between_, state_of(between_.motion, blocks[0], has_motion ? blocks[1] : nullptr),
                   state_of(between_.motion, blocks[to], has_motion ? blocks[3] : nullptr), gravity_);
  const Index n = e.error.size();
  Eigen::Map<Eigen::VectorXd>(residuals, n) = whitener_ * e.error;
  if (jacobians == nullptr) {
    return true;
  }
  for (const int side : {0, to}) {
    const MatrixXd J = multiply(whitener_, side == 0 ? e.J_from : e.J_to);
    if (jacobians[side] != nullptr) {
      Eigen::Map<RowMajor> out(jacobians[side], n, kPoseBlock);
      out.leftCols<kPoseTangent>() = J.leftCols<kPoseTangent>();
      out.rightCols<1>().setZero();
    }
    if (has_motion && jacobians[side + 1] != nullptr) {
      Eigen::Map<RowMajor>(jacobians[side + 1], n, n - kPoseTangent) = J.rightCols(n - kPoseTangent);
    }
  }
  return true;
}

}  // namespace limber::detail
