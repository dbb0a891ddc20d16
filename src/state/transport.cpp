// SPDX-License-Identifier: MIT
// What a correction moves Estimate's mean by, and how its covariance is carried along (see
// Estimate::retract), or cut off where the body is placed anew.
#include <array>
#include <span>
#include <vector>

#include "limber/core/dense.hpp"
#include "limber/core/so3.hpp"
#include "limber/state/estimate.hpp"
#include "limber/state/world_turn.hpp"

namespace limber {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using L = StateLayout;

/// What a correction moves everything by.
VectorXd Estimate::displacements(const VectorXd& dx, const WorldChange& by) const {
  VectorXd out = dx;
  const Vector3d grown = by.positions.beyond_linear() * (nav_.T_world_body.p - centre_of_growth_);
  out.segment<3>(L::kPosition) = turned_with_world(dx.segment<3>(L::kPosition) + grown, by.turn);
  if (layout_.motion != MotionModel::kOdometry) {
    const Vector3d faster = by.velocity.beyond_linear() * nav_.v_world_body;
    out.segment<3>(L::kVelocity) = turned_with_world(dx.segment<3>(L::kVelocity) + faster, by.turn);
  }
  for (Index at = layout_.map_begin(); at < size(); at += kTriplet) {
    out.segment<3>(at) = at < frozen_end_ ? displacement_of_frozen(at, dx.segment<3>(at), by)
                                          : displacement(active_blocks_[slot(at)], dx.segment<3>(at), by);
  }
  return out;
}

/// Of a triplet of the map whose error is as defined now.
Vector3d Estimate::displacement(StateBlock block, const Vector3d& dx, const WorldChange& by) const {
  const Vector3d out = scaled(block, dx, by);
  return is_world_vector(block) ? turned_with_world(out, by.turn) : out;
}

/// P and dx are those of the error as it was when the epoch began. Now it is that less [moved]_x R dtheta
/// (world vectors), turned back (attitudes), and more by what has grown: see refer_to_epoch.
Vector3d Estimate::displacement_of_frozen(Index at, const Vector3d& dx, const WorldChange& by) const {
  const StateBlock block = active_blocks_[slot(at)];
  const Vector3d moved = displacement_in_epoch(at);
  if (block.owner == Owner::kAnchorAttitude) {
    return so3_exp(-moved) * dx;
  }
  const Vector3d out = scaled(block, dx, by) + by.log * grown(block, moved);
  return is_world_vector(block) ? turned_with_world(out + by.turn.cross(moved), by.turn) : out;
}

/// To those of the frozen triplets.
void Estimate::add_displacements(const VectorXd& dx, const VectorXd& moved) {
  drift_ += dx.segment(layout_.map_begin(), drift_.size());
  for (Index k = 0; k < moved_.size(); k += kTriplet) {
    const Index at = layout_.map_begin() + k;
    const Vector3d by = moved.segment<kTriplet>(at);
    moved_.segment<kTriplet>(k) = active_blocks_[slot(at)].owner == Owner::kAnchorAttitude
                                      ? so3_log(so3_exp(moved_.segment<kTriplet>(k)) * so3_exp(by))
                                      : Vector3d(moved_.segment<kTriplet>(k) + by);
  }
}

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

void Estimate::refer_back(const VectorXd& dx, SparseJacobian& H) const {
  const VectorXd moved = displacements(dx, world_change(dx, {}));
  std::vector<SparseJacobian::Block> further;
  for (SparseJacobian::Block& block : H.blocks) {
    const Index at = block.col;
    const bool is_velocity = at == L::kVelocity && layout_.motion != MotionModel::kOdometry;
    const bool is_mapped = at >= layout_.map_begin(), is_carried = is_mapped && at >= frozen_end_;
    const StateBlock own = is_mapped ? active_blocks_[slot(at)] : StateBlock{Owner::kBodyClone, 0};
    if (at == L::kPosition || is_velocity || (is_carried && is_world_vector(own))) {
      further.push_back({block.row, L::kAttitude,
                         block.value * (-skew(moved.segment<kTriplet>(at)) * nav_.T_world_body.R)});
    }
    if (layout_.has_map_scale && (at == L::kPosition || is_velocity || is_carried)) {
      const Vector3d by = is_mapped ? grown(own, moved.segment<3>(at)) : moved.segment<3>(at);
      further.push_back({block.row, layout_.map_scale(), block.value * by * Eigen::RowVector3d::UnitX()});
    }
    if (at == L::kAttitude || (is_carried && own.owner == Owner::kAnchorAttitude)) {
      block.value = (block.value * so3_exp(-dx.segment<kTriplet>(at))).eval();
    }
  }
  H.blocks.insert(H.blocks.end(), further.begin(), further.end());
}

void Estimate::place_body(const Pose& there, double position, double attitude, double velocity) {
  nav_.T_world_body = there;
  const bool has_velocity = layout_.motion != MotionModel::kOdometry;
  const std::array<Index, 3> blocks = {L::kPosition, L::kAttitude, L::kVelocity};
  const auto own = std::span(blocks).first(has_velocity ? 3 : 2);
  MatrixXd columns = MatrixXd::Zero(size(), kTriplet * static_cast<Index>(own.size()));
  const std::array<double, 3> sigma = {position, attitude, velocity};
  for (std::size_t k = 0; k < own.size(); ++k) {
    columns.block<kTriplet, kTriplet>(own[k], kTriplet * static_cast<Index>(k))
        .diagonal()
        .setConstant(sigma[k] * sigma[k]);
  }
  P_.scatter(own, columns);
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
