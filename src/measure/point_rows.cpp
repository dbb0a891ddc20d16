// SPDX-License-Identifier: MIT
#include "limber/measure/point_rows.hpp"

namespace limber {

using Eigen::Index;
using L = StateLayout;

namespace {

using Blocks = std::vector<SparseJacobian::Block>;

void push_block_of_six(Blocks& blocks, Index row, Index col, const Eigen::Matrix<double, 2, kBlockSize>& J) {
  if (!J.isZero(0.0)) {
    blocks.push_back({row, col, J.leftCols<kTriplet>()});
    blocks.push_back({row, col + kTriplet, J.rightCols<kTriplet>()});
  }
}

/// What the pose at exposure owes to the body's motion since the stamp.
void push_motion(Blocks& blocks, Index row, const PointProjection::MotionJacobians& J, MotionModel motion) {
  switch (motion) {
    case MotionModel::kImu:
      blocks.push_back({row, L::kVelocity, J.velocity});
      blocks.push_back({row, L::kBiasGyro, -J.rate});
      break;
    case MotionModel::kConstantVelocity:
      blocks.push_back({row, L::kVelocity, J.velocity});
      blocks.push_back({row, L::kRate, J.rate});
      break;
    case MotionModel::kOdometry:
      break;
  }
}

}  // namespace

LinearMeasurement empty_measurement(Index rows, Index parameters) {
  LinearMeasurement out;
  out.residual.setZero(rows);
  out.sigma.setOnes(rows);
  out.D.setZero(rows, parameters);
  return out;
}

void write_point_rows(LinearMeasurement& measurement, Index row, const Eigen::Vector2d& uv_measured,
                      const Eigen::Vector2d& sigma_px, const PointProjection& projection,
                      const Landmark& landmark, const Anchor* anchor, const StateLayout& layout) {
  measurement.residual.segment<2>(row) = uv_measured - projection.uv;
  measurement.sigma.segment<2>(row) = sigma_px;
  auto& blocks = measurement.H.blocks;
  blocks.push_back({row, L::kPosition, projection.J_position});
  blocks.push_back({row, L::kAttitude, projection.J_attitude});
  blocks.push_back({row, landmark.at, projection.J_landmark});
  if (anchor != nullptr) {
    blocks.push_back({row, anchor->position_at, projection.J_anchor_position});
    blocks.push_back({row, anchor->attitude_at, projection.J_anchor_attitude});
  }
  if (projection.J_motion) {
    push_motion(blocks, row, *projection.J_motion, layout.motion);
  }
  if (projection.J_map_scale) {
    blocks.push_back({row, layout.map_scale(), Eigen::Matrix<double, 2, 3>::Zero()});
    blocks.back().value.col(0) = *projection.J_map_scale;
  }
  measurement.D.middleRows<2>(row).leftCols<kBlockSize>() = projection.J_theta;
  if (layout.has_theta) {
    push_block_of_six(blocks, row, layout.theta(), projection.J_theta);
  }
  if (!projection.J_more) {
    return;
  }
  measurement.D.middleRows<2>(row).rightCols<kMoreParameters>() = *projection.J_more;
  for (std::size_t k = 0; k < layout.has_more.size(); ++k) {
    if (layout.has_more[k]) {
      push_block_of_six(blocks, row, layout.more(k),
                        projection.J_more->middleCols<kBlockSize>(kBlockSize * static_cast<Index>(k)));
    }
  }
}

}  // namespace limber
