// SPDX-License-Identifier: MIT
// How Estimate's covariance is carried along with a correction: see Estimate::retract.
#include <array>
#include <span>

#include "limber/core/dense.hpp"
#include "limber/core/so3.hpp"
#include "limber/state/estimate.hpp"

namespace limber {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using L = StateLayout;

void Estimate::transport(const Eigen::VectorXd& dx) {
  const Index attitude = L::kAttitude;
  const Matrix3d turned_back = so3_exp(-dx.segment<3>(attitude));
  // Rows of the world vectors: error − [dx]_x R dtheta; of lengths: + displacement * (error of the scale).
  MatrixXd U = MatrixXd::Zero(size(), coupled_columns());
  const auto couple = [&](Index at) {
    U.block<kTriplet, kTriplet>(at, 0) = -skew(dx.segment<3>(at)) * nav_.T_world_body.R;
  };
  couple(L::kPosition);
  couple_scale(U, L::kPosition, dx.segment<3>(L::kPosition));
  if (layout_.motion != MotionModel::kOdometry) {
    couple(L::kVelocity);
    couple_scale(U, L::kVelocity, dx.segment<3>(L::kVelocity));
  }
  for (Index at = frozen_end_; at < size(); at += kTriplet) {
    const StateBlock block = active_blocks_[slot(at)];
    if (block.owner == Owner::kAnchorAttitude) {
      P_.transform_triplet(at, so3_exp(-dx.segment<3>(at)));
    } else if (is_world_vector(block)) {
      couple(at);
    }
    couple_scale(U, at, grown(block, dx.segment<3>(at)));
  }
  U.block<kTriplet, kTriplet>(attitude, 0) = turned_back - Matrix3d::Identity();
  add_couplings(U);
}

/// E: the columns of the body's attitude and, if there is one, of the map's scale. U: size() ×
/// coupled_columns().
void Estimate::add_couplings(const MatrixXd& U) {
  const std::array<Index, 2> to = {L::kAttitude, layout_.map_scale()};
  add_couplings(U, std::span(to).first(static_cast<std::size_t>(U.cols() / kTriplet)));
}

/// P := (I + U Eᵀ) P (I + U Eᵀ)ᵀ, E: the columns of the triplets `to`, as many as U has.
void Estimate::add_couplings(const MatrixXd& U, std::span<const Index> to) {
  MatrixXd G, own(U.cols(), U.cols());
  P_.gather(to, G);
  for (std::size_t k = 0; k < to.size(); ++k) {
    own.middleRows<kTriplet>(kTriplet * static_cast<Index>(k)) = G.middleRows<kTriplet>(to[k]);
  }
  add_product(G, 0.5, U, own);
  P_.add_symmetric_product(U, G);
}

}  // namespace limber
