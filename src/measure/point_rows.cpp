// SPDX-License-Identifier: MIT
#include "limber/measure/point_rows.hpp"

namespace limber {

using Eigen::Index;
using L = StateLayout;

LinearMeasurement empty_measurement(Index rows) {
  LinearMeasurement out;
  out.residual.setZero(rows);
  out.sigma.setOnes(rows);
  out.D.setZero(rows, 6);
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
  measurement.D.middleRows<2>(row) = projection.J_theta;
  if (layout.has_theta && !projection.J_theta.isZero(0.0)) {
    blocks.push_back({row, layout.theta(), projection.J_theta.leftCols<3>()});
    blocks.push_back({row, layout.theta() + kTriplet, projection.J_theta.rightCols<3>()});
  }
}

}  // namespace limber
