// SPDX-License-Identifier: MIT
// Estimate's scale of the map: a common factor of all lengths that no frame tells. docs/derivations/scale.md
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "limber/state/estimate.hpp"

namespace limber {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using L = StateLayout;

namespace {

/// What nobody knows at all is not known worse than that [-]: new depths come from the assumed baseline,
/// which may be long or short by a half. Wider, one linear step could turn the map inside out.
constexpr double kWidest = 0.5;
constexpr double kJitter = 1e-4;       // of the map's scale [-]: keeps P positive definite
constexpr double kOwnError = 3e-3;     // of a log depth [-]: no landmark is trusted for more
constexpr double kStraightUpTo = 0.5;  // a correction of the log scale from where on the factor is bent

/// The factor of all lengths where the log scale is corrected by s: one over that of an inverse depth, which
/// goes down by the share s. It is linear in what frames are linear in, and stays positive.
double factor(double s) {
  constexpr double kAtBend = 1.0 / (1.0 - kStraightUpTo);
  return s < kStraightUpTo ? 1.0 / (1.0 - s) : kAtBend * std::exp(kAtBend * (s - kStraightUpTo));
}

}  // namespace

Estimate::ScaleShares Estimate::scale_shares() const {
  if (!layout_.has_map_scale || layout_.motion == MotionModel::kOdometry) {
    return {};
  }
  const Index scale = layout_.map_scale();
  const double variance = P_.diagonal_block<kTriplet>(scale)(0, 0);
  const auto share = [&](Index at, const Vector3d& length) {
    const double square = length.squaredNorm();
    const Vector3d along = P_.triplet_block(at, scale).col(0) / variance;
    return square > 0.0 ? std::clamp(along.dot(length) / square, 0.0, 1.0) : 1.0;
  };
  return {share(L::kPosition, nav_.T_world_body.p - centre_of_growth_),
          share(L::kVelocity, nav_.v_world_body)};
}

/// With odometry the map may be long or short, but the body is where odometry took it, however far from the
/// origin: a factor of its position would be wrong. Corrections of the scale are small there, and are applied
/// as they stand.
Estimate::WorldChange Estimate::world_change(const VectorXd& dx, const ScaleShares& grows) const {
  const Vector3d turn = nav_.T_world_body.R * dx.segment<3>(L::kAttitude);
  if (!layout_.has_map_scale) {
    return {turn};
  }
  const double log = dx(layout_.map_scale());
  if (layout_.motion == MotionModel::kOdometry) {
    return {turn, log};
  }
  const auto of = [log](double share) { return Factor{share * log, factor(share * log)}; };
  return {turn, log, of(1.0), of(grows.position), of(grows.velocity)};
}

/// A correction of a triplet of the map and, where all lengths grow, what a factor does to second order.
Vector3d Estimate::scaled(StateBlock block, const Vector3d& dx, const WorldChange& by) const {
  if (!layout_.has_map_scale) {
    return dx;
  }
  if (block.owner == Owner::kAnchorPosition) {
    return dx + by.positions.beyond_linear() * (anchors_[block.index].T_world_body.p - centre_of_growth_);
  }
  if (block.owner != Owner::kLandmark) {
    return dx;
  }
  const Landmark& landmark = landmarks_[block.index];
  return landmark.kind == LandmarkKind::kCartesian
             ? Vector3d(dx + by.positions.beyond_linear() * (landmark.value - centre_of_growth_))
             : Vector3d(dx + Vector3d(0.0, 0.0, by.depths.beyond_linear_inverse() * landmark.value.z()));
}

/// What a triplet moves by, per unit of the scale's error, more after a displacement than before it.
Vector3d Estimate::grown(StateBlock block, const Vector3d& displacement) const {
  if (is_world_vector(block)) {
    return displacement;
  }
  return block.owner == Owner::kLandmark ? Vector3d(0.0, 0.0, -displacement.z()) : Vector3d::Zero();
}

void Estimate::couple_scale(MatrixXd& U, Index at, const Vector3d& grown) const {
  if (layout_.has_map_scale) {
    U.block<kTriplet, 1>(at, kTriplet) = grown;
  }
}

/// Of each active landmark the error of its log depth: what of its triplet and, if it is Cartesian, of the
/// body's position.
std::vector<Estimate::LogDepth> Estimate::log_depths() const {
  std::vector<LogDepth> depths;
  for (const Landmark& landmark : landmarks_) {
    LogDepth depth{landmark.at, Vector3d::Zero(), Vector3d::Zero(), 0.0};
    if (landmark.passive) {
      continue;
    }
    if (landmark.kind == LandmarkKind::kCartesian) {
      const Vector3d ray = landmark.value - nav_.T_world_body.p;
      depth.of_landmark = ray / ray.squaredNorm();
      depth.of_body = -depth.of_landmark;
    } else if (landmark.value.z() > 0.0) {
      depth.of_landmark.z() = -1.0 / landmark.value.z();
    } else {
      continue;
    }
    const Vector3d of_both = P_.triplet_block(landmark.at, L::kPosition) * depth.of_body;
    depth.variance =
        depth.of_landmark.dot(P_.diagonal_block<3>(landmark.at) * depth.of_landmark + 2.0 * of_both) +
        depth.of_body.dot(P_.diagonal_block<3>(L::kPosition) * depth.of_body);
    depths.push_back(depth);
  }
  return depths;
}

void Estimate::refresh_map_scale() {
  if (!layout_.has_map_scale) {
    return;
  }
  const std::vector<LogDepth> depths = log_depths();
  double best = std::numeric_limits<double>::infinity();
  for (const LogDepth& depth : depths) {
    best = std::min(best, depth.variance);
  }
  double total = depths.empty() ? 1.0 : 0.0;
  VectorXd c = VectorXd::Zero(size());
  for (const LogDepth& depth : depths) {
    // What is beyond the best one's is a landmark's own; the rest may be everybody's.
    const double weight = 1.0 / (depth.variance - best + kOwnError * kOwnError);
    c.segment<3>(depth.at) += weight * depth.of_landmark;
    c.segment<3>(L::kPosition) += weight * depth.of_body;
    total += weight;
  }
  c /= total;
  const Index at = layout_.map_scale();
  MatrixXd columns = MatrixXd::Zero(size(), kTriplet);
  columns.col(0) = P_.times(c);
  columns.middleRows<kTriplet>(at).setIdentity();
  columns(at, 0) = c.dot(columns.col(0)) + kJitter * kJitter;
  P_.scatter(std::array<Index, 1>{at}, columns);
  if (columns(at, 0) > kWidest * kWidest) {  // as if it had been measured, and nothing been wrong
    P_.subtract_outer(columns.leftCols<1>() / std::sqrt(columns(at, 0) + kWidest * kWidest));
  }
}

Estimate::Considered Estimate::considered(Index at) const {
  const double variance = P_.diagonal_block<kTriplet>(at)(0, 0);
  return {at, P_.times(VectorXd::Unit(size(), at)) / variance, variance};
}

/// The gain K becomes (I - r cᵀ) K, with the state cᵀx and r = P c / cᵀPc: that of errors beside it is the
/// best one still, since they are not correlated with it.
void Estimate::hold(const Considered& before, VectorXd& dx) {
  dx -= before.along * dx(before.at);
  const double learned = before.variance - P_.diagonal_block<kTriplet>(before.at)(0, 0);
  if (learned > 0.0) {
    P_.add_outer(std::sqrt(learned) * before.along);
  }
}

void Estimate::set_odometry_scale_sigma(double sigma) {
  P_.set_diagonal_block(layout_.odometry_scale(), Matrix3d(Vector3d(sigma * sigma, 1.0, 1.0).asDiagonal()));
}

void Estimate::move_with_odometry_scale(const Vector3d& by) {
  Matrix3d U = Matrix3d::Zero();
  U.col(0) = by;
  static_assert(L::kPosition == 0);
  P_.couple_leading(U, layout_.odometry_scale());
}

}  // namespace limber
