// SPDX-License-Identifier: MIT
// Estimate's epochs: who goes passive, who comes back, and the transport of the covariance that waited for
// it.
#include <algorithm>
#include <array>
#include <unordered_set>
#include <utility>

#include "limber/core/divergence_error.hpp"
#include "limber/core/so3.hpp"
#include "limber/state/estimate.hpp"

namespace limber {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using L = StateLayout;

/// Which anchors some landmark that does not rest stands on. @param resting  by landmark
std::vector<bool> Estimate::anchors_in_use(const std::vector<bool>& resting) const {
  std::vector<bool> in_use(anchors_.size(), false);
  for (std::size_t k = 0; k < landmarks_.size(); ++k) {
    if (landmarks_[k].anchor >= 0 && !resting[k]) {
      in_use[static_cast<std::size_t>(landmarks_[k].anchor)] = true;
    }
  }
  return in_use;
}

void Estimate::change_epoch(const std::vector<std::int64_t>& retired) {
  std::vector<bool> resting(landmarks_.size());
  std::transform(landmarks_.begin(), landmarks_.end(), resting.begin(),
                 [](const Landmark& landmark) { return landmark.passive; });
  for (const std::int64_t id : retired) {
    resting[index_of_.at(id)] = true;
  }
  const std::vector<bool> in_use = anchors_in_use(resting);

  EpochChange change;
  const Eigen::VectorXd corrections = passive_.correction(drift_);
  std::vector<Move> kept, passive;
  for (std::size_t k = 0; k < passive_blocks_.size(); ++k) {
    const Vector3d correction = corrections.segment<kTriplet>(kTriplet * static_cast<Index>(k));
    passive.push_back({passive_blocks_[k], displacement(passive_blocks_[k], correction, changed_)});
  }
  for (std::size_t k = 0; k < active_blocks_.size(); ++k) {
    const StateBlock block = active_blocks_[k];
    const Index at = layout_.map_begin() + kTriplet * static_cast<Index>(k);
    const Vector3d displacement = displacement_in_epoch(at);
    if (block.owner == Owner::kBodyClone || block.owner == Owner::kBuried) {
      change.dropped.push_back(at);
    } else if (block.owner == Owner::kLandmark ? resting[block.index] : !in_use[block.index]) {
      change.retired.push_back(at);
      passive.push_back({block, displacement});
    } else {
      change.kept.push_back(at);
      kept.push_back({block, displacement});
    }
  }
  const std::size_t passive_before = passive_blocks_.size();
  if (!passive_.change_epoch(P_, layout_.map_begin(), change)) {
    throw DivergenceError("map: the covariance is not positive definite where an epoch ends");
  }
  for (std::size_t k = 0; k < passive_before; ++k) {
    retract_triplet(passive[k].block, passive[k].displacement);
  }
  const Index clones = passive_.z_size() > 0 ? layout_.map_begin() / kTriplet : 0;
  active_blocks_.assign(static_cast<std::size_t>(clones) + kept.size(), {Owner::kBodyClone, 0});
  passive_blocks_.resize(passive.size());
  for (std::size_t k = 0; k < kept.size(); ++k) {
    move_in(kept[k].block, layout_.map_begin() + kTriplet * (clones + static_cast<Index>(k)), false);
  }
  for (std::size_t k = 0; k < passive.size(); ++k) {
    move_in(passive[k].block, kTriplet * static_cast<Index>(k), true);
  }
  carry_active(kept);
  carry_passive(passive);
  frozen_end_ = passive_.z_size() > 0 ? P_.size() : layout_.map_begin();
  drift_.setZero(frozen_end_ - layout_.map_begin());
  moved_ = drift_;
  changed_ = {};
  refresh_map_scale();
  size_as_epoch_began_ = P_.size();
  epoch_began_ns_ = nav_.t_ns;
}

/// What transport() does for the rest of the state, for those whose displacement has gathered since.
void Estimate::carry_active(const std::vector<Move>& kept) {
  MatrixXd U = MatrixXd::Zero(size(), coupled_columns());
  const Index first = size() - kTriplet * static_cast<Index>(kept.size());
  for (std::size_t k = 0; k < kept.size(); ++k) {
    const Index at = first + kTriplet * static_cast<Index>(k), column = at - layout_.map_begin();
    if (kept[k].block.owner == Owner::kAnchorAttitude) {
      const Matrix3d turned_back = so3_exp(-kept[k].displacement);
      P_.transform_triplet(at, turned_back);
      if (!passive_.empty()) {
        passive_.transform_column(column, turned_back);
      }
    } else if (is_world_vector(kept[k].block)) {
      U.block<kTriplet, kTriplet>(at, 0) = -skew(kept[k].displacement) * nav_.T_world_body.R;
    }
    couple_scale(U, at, grown(kept[k].block, kept[k].displacement));
  }
  if (!passive_.empty()) {
    const std::array<Index, 2> to = {L::kAttitude, layout_.map_scale()};
    for (Index k = 0; kTriplet * k < U.cols(); ++k) {
      passive_.couple_columns(to[static_cast<std::size_t>(k)],
                              U.block(layout_.map_begin(), kTriplet * k, passive_.z_size(), kTriplet));
    }
  }
  add_couplings(U);
}

void Estimate::carry_passive(const std::vector<Move>& passive) {
  for (std::size_t k = 0; k < passive.size(); ++k) {
    const Index row = kTriplet * static_cast<Index>(k);
    if (passive[k].block.owner == Owner::kAnchorAttitude) {
      passive_.transform_row(row, so3_exp(-passive[k].displacement));
    } else if (is_world_vector(passive[k].block)) {
      passive_.couple_row(row, L::kAttitude, -skew(passive[k].displacement) * nav_.T_world_body.R);
    }
    if (layout_.has_map_scale) {
      passive_.couple_row(row, layout_.map_scale(),
                          grown(passive[k].block, passive[k].displacement) * Eigen::RowVector3d::UnitX());
    }
  }
}

/// Of a triplet of the map, as far as the covariance has not been carried along; zero unless it is frozen.
Vector3d Estimate::displacement_in_epoch(Index at) const {
  return at < frozen_end_ ? Vector3d(moved_.segment<kTriplet>(at - layout_.map_begin())) : Vector3d::Zero();
}

void Estimate::refer_to_epoch(const Landmark& landmark, PointProjection& projection) const {
  const Anchor* anchor = anchor_of(landmark);
  // Error of a world vector now: its own in P − [displacement]_x R dtheta, as in transport().
  const Matrix3d R = nav_.T_world_body.R;
  if (layout_.has_map_scale && landmark.at < frozen_end_) {
    const auto grown_since = [&](Index at) {
      return grown(active_blocks_[slot(at)], displacement_in_epoch(at));
    };
    projection.J_map_scale = projection.J_landmark * grown_since(landmark.at);
    if (anchor != nullptr) {
      *projection.J_map_scale += projection.J_anchor_position * grown_since(anchor->position_at);
    }
  }
  if (anchor == nullptr) {
    projection.J_attitude -= projection.J_landmark * skew(displacement_in_epoch(landmark.at)) * R;
    return;
  }
  projection.J_attitude -=
      projection.J_anchor_position * skew(displacement_in_epoch(anchor->position_at)) * R;
  projection.J_anchor_attitude *= so3_exp(-displacement_in_epoch(anchor->attitude_at));
}

/// Rows in the passive block of passive landmarks and of those of their anchors that are passive too.
std::vector<Index> Estimate::rows_of(const std::vector<std::int64_t>& passive) const {
  std::vector<Index> rows;
  std::unordered_set<int> anchors;
  for (const std::int64_t id : passive) {
    const Landmark& landmark = landmarks_[index_of_.at(id)];
    rows.push_back(landmark.at);
    const Anchor* anchor = anchor_of(landmark);
    if (anchor != nullptr && anchor->passive && anchors.insert(landmark.anchor).second) {
      rows.push_back(anchor->position_at);
      rows.push_back(anchor->attitude_at);
    }
  }
  return rows;
}

void Estimate::recall(const std::vector<std::int64_t>& recalled) {
  std::vector<Index> rows = rows_of(recalled);
  if (rows.empty()) {
    return;
  }
  std::vector<Move> woken;
  std::vector<Vector3d> corrections;
  for (const Index row : rows) {
    const StateBlock block = passive_blocks_[static_cast<std::size_t>(row / kTriplet)];
    woken.push_back({block, passive_displacement(row)});
    corrections.push_back(passive_.correction(row, drift_));
    retract_triplet(block, woken.back().displacement);
  }
  passive_.recall(P_, layout_.map_begin(), rows);
  std::sort(rows.rbegin(), rows.rend());
  for (const Index row : rows) {
    const StateBlock moved = passive_blocks_.back();
    passive_blocks_.pop_back();
    if (static_cast<std::size_t>(row / kTriplet) < passive_blocks_.size()) {
      move_in(moved, row, true);
    }
  }
  for (std::size_t k = 0; k < woken.size();
       ++k) {  // each takes the place of a new landmark, who moves to the end
    const Move& move = woken[k];
    const Index end = layout_.map_begin() + kTriplet * static_cast<Index>(active_blocks_.size());
    active_blocks_.push_back(move.block);
    if (frozen_end_ != end) {
      move_in(active_blocks_[slot(frozen_end_)], end, false);
    }
    move_in(move.block, frozen_end_, false);
    frozen_end_ += kTriplet;
    drift_.conservativeResize(drift_.size() + kTriplet);
    drift_.tail<kTriplet>() = corrections[k];
    moved_.conservativeResize(moved_.size() + kTriplet);
    moved_.tail<kTriplet>() = move.displacement;
  }
}

Matrix3d Estimate::joint_block(Index row, bool row_passive, Index col, bool col_passive) const {
  if (row_passive && col_passive) {
    return passive_.triplet_block(P_, layout_.map_begin(), row, col);
  }
  if (row_passive) {
    return passive_.cross(P_, layout_.map_begin(), row).middleCols<kTriplet>(col);
  }
  return col_passive ? joint_block(col, true, row, false).transpose() : P_.triplet_block(row, col);
}

Landmark Estimate::corrected(Landmark landmark, const Vector3d& correction) {
  landmark.value += correction;
  return landmark;
}

Anchor Estimate::corrected(Anchor anchor, const Vector3d& dp, const Vector3d& dtheta) {
  anchor.T_world_body.p += dp;
  anchor.T_world_body.R = anchor.T_world_body.R * so3_exp(dtheta);
  return anchor;
}

/// With the corrections that a passive landmark's mean has not been given yet.
Landmark Estimate::current(const Landmark& landmark) const {
  return landmark.passive ? corrected(landmark, passive_displacement(landmark.at)) : landmark;
}

Anchor Estimate::current(const Anchor& anchor) const {
  return anchor.passive ? corrected(anchor, passive_displacement(anchor.position_at),
                                    passive_displacement(anchor.attitude_at))
                        : anchor;
}

/// What the passive triplet at `row` has moved by since the epoch began, though its mean waits for it.
Vector3d Estimate::passive_displacement(Index row) const {
  return displacement(passive_blocks_[static_cast<std::size_t>(row / kTriplet)],
                      passive_.correction(row, drift_), changed_);
}

std::vector<Vector3d> Estimate::landmark_positions() const {
  const Eigen::VectorXd corrections = passive_.correction(drift_);
  const auto of_row = [&](Index row) {
    return displacement(passive_blocks_[static_cast<std::size_t>(row / kTriplet)],
                        corrections.segment<kTriplet>(row), changed_);
  };
  std::vector<Vector3d> positions;
  positions.reserve(landmarks_.size());
  for (const Landmark& stored : landmarks_) {
    const Landmark landmark = stored.passive ? corrected(stored, of_row(stored.at)) : stored;
    const Anchor* anchor = anchor_of(stored);
    if (anchor == nullptr || !anchor->passive) {
      positions.push_back(world_position(landmark, anchor));
    } else {
      const Anchor moved = corrected(*anchor, of_row(anchor->position_at), of_row(anchor->attitude_at));
      positions.push_back(world_position(landmark, &moved));
    }
  }
  return positions;
}

}  // namespace limber
