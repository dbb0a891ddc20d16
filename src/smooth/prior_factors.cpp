// SPDX-License-Identifier: MIT
#include <utility>

#include "factors.hpp"
#include "limber/core/so3.hpp"

namespace limber::detail {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::VectorXd;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

namespace {

int tangent_size(int block_size) { return block_size == kPoseBlock ? kPoseTangent : block_size; }

}  // namespace

BlockPrior::BlockPrior(std::vector<int> block_sizes, VectorXd x0, Eigen::MatrixXd A, VectorXd b)
    : sizes_(std::move(block_sizes)), x0_(std::move(x0)), A_(std::move(A)), b_(std::move(b)) {
  set_num_residuals(static_cast<int>(A_.rows()));
  mutable_parameter_block_sizes()->assign(sizes_.begin(), sizes_.end());
}

bool BlockPrior::Evaluate(double const* const* blocks, double* residuals, double** jacobians) const {
  VectorXd d(A_.cols());
  Index at = 0, tangent_at = 0;
  for (std::size_t k = 0; k < sizes_.size(); ++k) {
    const int size = sizes_[k], tangent = tangent_size(size);
    const double* x0 = x0_.data() + at;
    Matrix3d J_attitude = Matrix3d::Identity();
    if (size == kPoseBlock) {
      const Pose before = pose_of(x0), now = pose_of(blocks[k]);
      const Eigen::Vector3d turn = so3_log(before.R.transpose() * now.R);
      d.segment<kPoseTangent>(tangent_at) << now.p - before.p, turn;
      J_attitude = so3_right_jacobian_inverse(turn);
    } else {
      d.segment(tangent_at, size) =
          Eigen::Map<const VectorXd>(blocks[k], size) - Eigen::Map<const VectorXd>(x0, size);
    }
    if (jacobians != nullptr && jacobians[k] != nullptr) {
      Eigen::Map<RowMajor> J(jacobians[k], A_.rows(), size);
      J.setZero();
      J.leftCols(tangent) = A_.middleCols(tangent_at, tangent);
      if (size == kPoseBlock) {
        J.middleCols<3>(3) *= J_attitude;
      }
    }
    at += size;
    tangent_at += tangent;
  }
  Eigen::Map<VectorXd>(residuals, A_.rows()) = A_ * d + b_;
  return true;
}

WalkFactor::WalkFactor(const RigParameters& sigma) : weight_(sigma.cwiseInverse()) {
  set_num_residuals(kBlockSize);
  *mutable_parameter_block_sizes() = {kBlockSize, kBlockSize};
}

bool WalkFactor::Evaluate(double const* const* blocks, double* residuals, double** jacobians) const {
  using Map = Eigen::Map<const RigParameters>;
  Eigen::Map<RigParameters>{residuals} = weight_.cwiseProduct(Map(blocks[1]) - Map(blocks[0]));
  for (int side = 0; jacobians != nullptr && side < 2; ++side) {
    if (jacobians[side] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>> J(jacobians[side]);
      J.setZero();
      J.diagonal() = side == 0 ? RigParameters(-weight_) : weight_;
    }
  }
  return true;
}

}  // namespace limber::detail
