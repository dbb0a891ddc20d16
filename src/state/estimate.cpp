// SPDX-License-Identifier: MIT
#include "limber/state/estimate.hpp"

#include <array>
#include <stdexcept>
#include <string>
#include <utility>

#include "limber/core/dense.hpp"
#include "limber/core/so3.hpp"

namespace limber {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using L = StateLayout;

namespace {

constexpr double kCloneJitterPosition = 1e-6;  // [m]
constexpr double kRounding = 1e-12;            // of a variance, over many updates
constexpr double kCloneJitterAttitude = 1e-7;  // [rad]

/// The mount's six parameters in the error state.
Index mount_in(const StateLayout& layout) { return layout.more(layout.has_more.size() - 1); }

void retract_attitude(Matrix3d& R, const Vector3d& dtheta) { R = so3_normalized(R * so3_exp(dtheta)); }

}  // namespace

Estimate::Estimate(StateLayout layout, const NavigationState& nav_state, const MatrixXd& body_covariance,
                   const RigParameters& rig, const Eigen::Matrix<double, 6, 6>& theta_covariance)
    : nav_(nav_state), theta_(rig), layout_(layout) {
  if (body_covariance.rows() != layout.body_size() || body_covariance.cols() != layout.body_size()) {
    throw std::invalid_argument("estimate: the body's covariance is " +
                                std::to_string(body_covariance.rows()) + "x" +
                                std::to_string(body_covariance.cols()) + ", expected " +
                                std::to_string(layout.body_size()) + " wide");
  }
  P_.append(layout.map_begin());
  frozen_end_ = layout.map_begin();
  P_.set_diagonal_block(0, body_covariance);
  if (layout.has_theta) {
    P_.set_diagonal_block(layout.theta(), theta_covariance);
  }
  if (layout.has_map_scale) {
    P_.set_diagonal_block(layout.map_scale(), Matrix3d::Identity());
    refresh_map_scale();
  }
  if (layout.has_odometry_scale) {
    P_.set_diagonal_block(layout.odometry_scale(), Matrix3d::Identity());
  }
  if (layout.has_supposed_steps) {
    restart_bias_steps();
    restart_clock_step();
  }
}

const Landmark* Estimate::find(std::int64_t track_id) const {
  const auto it = index_of_.find(track_id);
  return it == index_of_.end() ? nullptr : &landmarks_[it->second];
}

Landmark* Estimate::find(std::int64_t track_id) {
  return const_cast<Landmark*>(static_cast<const Estimate*>(this)->find(track_id));
}

const Anchor* Estimate::anchor_of(const Landmark& landmark) const {
  return landmark.kind == LandmarkKind::kCartesian ? nullptr
                                                   : &anchors_[static_cast<std::size_t>(landmark.anchor)];
}

void Estimate::retract(const Eigen::VectorXd& dx, const ScaleShares& grows) {
  const WorldChange by = world_change(dx, grows);
  const VectorXd moved = displacements(dx, by);
  transport(moved);
  nav_.T_world_body.p += moved.segment<3>(L::kPosition);
  retract_attitude(nav_.T_world_body.R, dx.segment<3>(L::kAttitude));
  if (layout_.motion != MotionModel::kOdometry) {
    nav_.v_world_body += moved.segment<3>(L::kVelocity);
  }
  if (layout_.motion == MotionModel::kConstantVelocity) {
    nav_.omega_body += dx.segment<3>(L::kRate);
  }
  if (layout_.motion == MotionModel::kImu) {
    nav_.bias_gyro += dx.segment<3>(L::kBiasGyro);
    nav_.bias_accel += dx.segment<3>(L::kBiasAccel);
  }
  retract_parameters(dx);
  if (layout_.has_witness) {
    witness_ += dx.segment<6>(layout_.witness());
  }
  if (layout_.has_supposed_steps) {
    steps_ += dx.segment<7>(layout_.supposed_steps());
  }
  for (std::size_t k = 0; k < active_blocks_.size(); ++k) {
    retract_triplet(active_blocks_[k],
                    moved.segment<3>(layout_.map_begin() + kTriplet * static_cast<Index>(k)));
  }
  add_displacements(dx, moved);
  changed_ += by;
}

void Estimate::retract_parameters(const Eigen::VectorXd& dx) {
  if (layout_.has_theta) {
    theta_ += dx.segment<6>(layout_.theta());
  }
  for (std::size_t k = 0; k < layout_.has_more.size(); ++k) {
    if (layout_.has_more[k]) {
      more_.segment<6>(6 * static_cast<Index>(k)) += dx.segment<6>(layout_.more(k));
    }
  }
  if (layout_.has_more.back()) {  // the mount's rotation: Exp(more) := Exp(dx) Exp(more)
    const Index k = kMoreParameters - 6;
    const Vector3d turn = dx.segment<3>(mount_in(layout_));
    more_.segment<3>(k) = so3_log(so3_exp(turn) * so3_exp(more_.segment<3>(k) - turn));
  }
}

void Estimate::retract_triplet(StateBlock block, const Vector3d& dx) {
  switch (block.owner) {
    case Owner::kLandmark:
      landmarks_[block.index].value += dx;
      break;
    case Owner::kAnchorPosition:
      anchors_[block.index].T_world_body.p += dx;
      break;
    case Owner::kAnchorAttitude:
      retract_attitude(anchors_[block.index].T_world_body.R, dx);
      break;
    case Owner::kBodyClone:
    case Owner::kBuried:
      break;
  }
}

void Estimate::shrink_mount_rotation(double kept) {
  more_.segment<3>(kMoreParameters - 6) *= kept;
  P_.transform_triplet(mount_in(layout_), kept * Matrix3d::Identity());
}

bool Estimate::is_world_vector(StateBlock block) const {
  return block.owner == Owner::kAnchorPosition ||
         (block.owner == Owner::kLandmark && landmarks_[block.index].kind == LandmarkKind::kCartesian);
}

void Estimate::restart_witness(double sigma) {
  witness_.setZero();
  const std::array<Index, 2> block = {layout_.witness(), layout_.witness() + kTriplet};
  MatrixXd columns = MatrixXd::Zero(size(), 6);
  columns.middleRows<6>(layout_.witness()).diagonal().setConstant(sigma * sigma);
  P_.scatter(block, columns);
}

void Estimate::promote_witness(const MatrixXd& directions) {
  MatrixXd B = MatrixXd::Zero(6, 6);
  B.leftCols(directions.cols()) = directions;
  theta_ += B * witness_;
  const std::array<Index, 2> block = {layout_.witness(), layout_.witness() + kTriplet};
  MatrixXd columns;
  P_.gather(block, columns);
  columns = multiply(columns, transposed(B));
  columns.middleRows<6>(layout_.witness()) = (B * columns.middleRows<6>(layout_.witness())).eval();
  P_.scatter(block, columns);
  layout_.has_theta = true;
  layout_.has_witness = false;
}

Index Estimate::append_triplet(StateBlock block) {
  active_blocks_.push_back(block);
  return P_.append(kTriplet);
}

void Estimate::remove_triplet(Index at, bool passive) {
  if (!passive && at < frozen_end_) {
    active_blocks_[slot(at)] = {Owner::kBuried, 0};
    return;
  }
  std::vector<StateBlock>& blocks = passive ? passive_blocks_ : active_blocks_;
  const Index moved_from = passive ? passive_.remove(at) : P_.remove_triplet(at);
  const StateBlock moved = blocks.back();
  blocks.pop_back();
  if (moved_from != at) {
    move_in(moved, at, passive);
  }
}

/// Writes down, on both sides, where a block lives.
void Estimate::move_in(StateBlock block, Index at, bool passive) {
  (passive ? passive_blocks_[static_cast<std::size_t>(at / kTriplet)] : active_blocks_[slot(at)]) = block;
  switch (block.owner) {
    case Owner::kLandmark:
      landmarks_[block.index].at = at;
      landmarks_[block.index].passive = passive;
      break;
    case Owner::kAnchorPosition:
      anchors_[block.index].position_at = at;
      anchors_[block.index].passive = passive;
      break;
    case Owner::kAnchorAttitude:
      anchors_[block.index].attitude_at = at;
      break;
    case Owner::kBodyClone:
    case Owner::kBuried:
      break;
  }
}

int Estimate::append_anchor(const Pose& T_world_frame, const Pose& T_frame_cam0) {
  std::size_t index = anchors_.size();
  if (free_anchors_.empty()) {
    anchors_.emplace_back();
  } else {
    index = static_cast<std::size_t>(free_anchors_.back());
    free_anchors_.pop_back();
  }
  Anchor& anchor = anchors_[index];
  anchor.T_world_body = T_world_frame;
  anchor.T_body_cam0 = T_frame_cam0;
  anchor.users = 0;
  anchor.passive = false;
  anchor.position_at = append_triplet({Owner::kAnchorPosition, index});
  anchor.attitude_at = append_triplet({Owner::kAnchorAttitude, index});
  return static_cast<int>(index);
}

/// @param columns  of P: those of the anchor's two triplets
void Estimate::add_jitter(const Anchor& anchor, MatrixXd& columns) const {
  for (Index k = 0; k < kTriplet; ++k) {
    const double rounding = kRounding * columns(anchor.position_at + k, k);
    columns(anchor.position_at + k, k) += kCloneJitterPosition * kCloneJitterPosition + rounding;
    columns(anchor.attitude_at + k, kTriplet + k) += kCloneJitterAttitude * kCloneJitterAttitude;
  }
}

int Estimate::add_anchor(const Pose& T_body_cam0) {
  const int index = append_anchor(nav_.T_world_body, T_body_cam0);
  const Anchor& anchor = anchors_[static_cast<std::size_t>(index)];
  // Same rows as the pose, plus the jitter on the diagonal.
  const std::array<Index, 2> pose = {L::kPosition, L::kAttitude};
  const std::array<Index, 2> clone = {anchor.position_at, anchor.attitude_at};
  MatrixXd columns;
  P_.gather(pose, columns);
  columns.middleRows<L::kPoseSize>(anchor.position_at) = columns.topRows<L::kPoseSize>().eval();
  add_jitter(anchor, columns);
  P_.scatter(clone, columns);
  return index;
}

int Estimate::add_camera_anchor(const CameraPose& pose) {
  const int index = append_anchor(pose.T_world_cam, Pose{});
  const Anchor& anchor = anchors_[static_cast<std::size_t>(index)];
  MatrixXd columns = MatrixXd::Zero(size(), L::kPoseSize), sources;
  for (const CameraPose::Block& block : pose.blocks) {
    P_.gather(std::array<Index, 1>{block.col}, sources);
    columns.noalias() += sources * block.value.transpose();
  }
  Eigen::Matrix<double, L::kPoseSize, L::kPoseSize> own;
  own.setZero();
  for (const CameraPose::Block& block : pose.blocks) {
    own += block.value * columns.middleRows<kTriplet>(block.col);
  }
  columns.middleRows<L::kPoseSize>(anchor.position_at) = 0.5 * (own + own.transpose());
  add_jitter(anchor, columns);
  P_.scatter(std::array<Index, 2>{anchor.position_at, anchor.attitude_at}, columns);
  return index;
}

Landmark& Estimate::add_landmark(Landmark landmark, const Matrix3d& P_ll, const MatrixXd& P_xl) {
  const Index before = size();
  landmark.at = append_triplet({Owner::kLandmark, landmarks_.size()});
  MatrixXd columns = MatrixXd::Zero(size(), kTriplet);
  if (P_xl.rows() > 0) {
    columns.topRows(before) = P_xl;
  }
  columns.bottomRows<kTriplet>() = 0.5 * (P_ll + P_ll.transpose());
  P_.scatter(std::array<Index, 1>{landmark.at}, columns);
  if (landmark.kind == LandmarkKind::kInverseDepth) {
    ++anchors_[static_cast<std::size_t>(landmark.anchor)].users;
  }
  index_of_[landmark.track_id] = landmarks_.size();
  landmarks_.push_back(landmark);
  return landmarks_.back();
}

void Estimate::remove_anchor(int anchor) {
  const bool passive = anchors_[static_cast<std::size_t>(anchor)].passive;
  remove_triplet(anchors_[static_cast<std::size_t>(anchor)].attitude_at, passive);
  remove_triplet(anchors_[static_cast<std::size_t>(anchor)].position_at, passive);
  free_anchors_.push_back(anchor);
}

void Estimate::release_anchor(int anchor) {
  if (--anchors_[static_cast<std::size_t>(anchor)].users == 0) {
    remove_anchor(anchor);
  }
}

void Estimate::drop_unused_anchor(int anchor) {
  if (anchor >= 0 && anchors_[static_cast<std::size_t>(anchor)].users == 0) {
    remove_anchor(anchor);
  }
}

void Estimate::remove_landmark(std::int64_t track_id) {
  const auto it = index_of_.find(track_id);
  if (it == index_of_.end()) {
    return;
  }
  const std::size_t index = it->second;
  const Landmark removed = landmarks_[index];
  index_of_.erase(it);
  remove_triplet(removed.at, removed.passive);
  if (index + 1 != landmarks_.size()) {
    landmarks_[index] = landmarks_.back();
    index_of_[landmarks_[index].track_id] = index;
    move_in({Owner::kLandmark, index}, landmarks_[index].at, landmarks_[index].passive);
  }
  landmarks_.pop_back();
  if (removed.kind == LandmarkKind::kInverseDepth) {
    release_anchor(removed.anchor);
  }
}

Eigen::Matrix<double, 3, 9> world_position_jacobian(const Landmark& landmark, const Anchor& anchor) {
  const double rho = landmark.value.z();
  const Matrix3d R_world_cam0 = anchor.T_world_body.R * anchor.T_body_cam0.R;
  const Vector3d direction = landmark.R_cam0_chart * Vector3d(landmark.value.x(), landmark.value.y(), 1.0);
  const Vector3d p_body = anchor.T_body_cam0 * Vector3d(direction / rho);
  Eigen::Matrix<double, 3, 9> J;
  J.leftCols<3>().setIdentity();
  J.middleCols<3>(3) = -anchor.T_world_body.R * skew(p_body);
  J.middleCols<2>(6) = R_world_cam0 * landmark.R_cam0_chart.leftCols<2>() / rho;
  J.col(8) = -(R_world_cam0 * direction) / (rho * rho);
  return J;
}

void Estimate::convert_to_cartesian(Landmark& landmark) {
  const Anchor anchor = *anchor_of(landmark);
  const Eigen::Matrix<double, 3, 9> J = world_position_jacobian(landmark, anchor);
  const std::array<Index, 3> sources = {anchor.position_at, anchor.attitude_at, landmark.at};
  MatrixXd gathered;
  P_.gather(sources, gathered);
  MatrixXd columns = gathered * J.transpose();
  Matrix3d P_ll = Matrix3d::Zero();
  for (std::size_t k = 0; k < sources.size(); ++k) {
    P_ll +=
        J.middleCols<kTriplet>(kTriplet * static_cast<Index>(k)) * columns.middleRows<kTriplet>(sources[k]);
  }
  columns.middleRows<kTriplet>(landmark.at) = 0.5 * (P_ll + P_ll.transpose());
  P_.scatter(std::array<Index, 1>{landmark.at}, columns);
  if (landmark.at < frozen_end_) {
    const auto column = [&](Index at) { return at - layout_.map_begin(); };
    passive_.transform_column(column(landmark.at), J.rightCols<3>());
    passive_.couple_column(column(landmark.at), column(anchor.position_at), J.leftCols<3>());
    passive_.couple_column(column(landmark.at), column(anchor.attitude_at), J.middleCols<3>(3));
  }

  landmark.value = world_position(landmark, &anchor);
  landmark.kind = LandmarkKind::kCartesian;
  const int released = landmark.anchor;
  landmark.anchor = -1;
  release_anchor(released);
}

Vector3d Estimate::landmark_position(const Landmark& stored, Matrix3d* covariance) const {
  const Landmark landmark = current(stored);
  if (landmark.kind == LandmarkKind::kCartesian) {
    if (covariance != nullptr) {
      *covariance = joint_block(landmark.at, landmark.passive, landmark.at, landmark.passive);
    }
    return landmark.value;
  }
  const Anchor anchor = current(*anchor_of(stored));
  if (covariance != nullptr) {
    const Eigen::Matrix<double, 3, 9> J = world_position_jacobian(landmark, anchor);
    const std::array<std::pair<Index, bool>, 3> sources = {{{anchor.position_at, anchor.passive},
                                                            {anchor.attitude_at, anchor.passive},
                                                            {landmark.at, landmark.passive}}};
    Eigen::Matrix<double, 9, 9> joint;
    for (std::size_t i = 0; i < sources.size(); ++i) {
      for (std::size_t j = 0; j < sources.size(); ++j) {
        joint.block<3, 3>(3 * static_cast<Index>(i), 3 * static_cast<Index>(j)) =
            joint_block(sources[i].first, sources[i].second, sources[j].first, sources[j].second);
      }
    }
    *covariance = J * joint * J.transpose();
  }
  return world_position(landmark, &anchor);
}

}  // namespace limber
