// SPDX-License-Identifier: MIT
#include "limber/landmarks/map_management.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <unordered_set>
#include <utility>
#include <vector>

#include "limber/core/time.hpp"

namespace limber {

using Eigen::Vector3d;

namespace {

double sigma_of_inverse_depth(const Estimate& estimate, const Landmark& landmark) {
  return std::sqrt(estimate.P().diagonal_block<3>(landmark.at)(2, 2));
}

std::vector<std::int64_t> to_remove(const Estimate& estimate, std::int64_t t_ns,
                                    const MapManagementOptions& options) {
  std::vector<std::int64_t> gone;
  std::vector<const Landmark*> unseen;
  for (const Landmark& landmark : estimate.landmarks()) {
    const double unseen_s = seconds_between(landmark.last_seen_ns, t_ns);
    if (landmark.refusals >= options.max_refusals || unseen_s > options.forget_after_s) {
      gone.push_back(landmark.track_id);
    } else if (landmark.last_seen_ns < t_ns) {
      unseen.push_back(&landmark);
    }
  }
  const std::size_t kept = estimate.landmarks().size() - gone.size();
  if (kept > options.max_landmarks) {
    const std::size_t excess = std::min(kept - options.max_landmarks, unseen.size());
    std::sort(unseen.begin(), unseen.end(), [](const Landmark* a, const Landmark* b) {
      return a->last_seen_ns != b->last_seen_ns ? a->last_seen_ns < b->last_seen_ns
                                                : a->track_id < b->track_id;
    });
    for (std::size_t k = 0; k < excess; ++k) {
      gone.push_back(unseen[k]->track_id);
    }
  }
  return gone;
}

/// Rewrites the landmarks seen at `seen_ns` that became linear enough.
void convert_linear(Estimate& estimate, std::int64_t seen_ns, const MapManagementOptions& options) {
  for (Landmark& landmark : estimate.landmarks()) {
    if (landmark.kind == LandmarkKind::kInverseDepth && landmark.last_seen_ns == seen_ns &&
        !landmark.passive && !estimate.is_frozen(landmark) &&
        linearity_index(estimate, landmark) < options.linearity_index) {
      estimate.convert_to_cartesian(landmark);
    }
  }
}

/// Landmarks that are out of sight go passive. @param seen  in the frame at t_ns
void end_epoch(Estimate& estimate, const std::unordered_set<std::int64_t>& seen, std::int64_t t_ns,
               std::int64_t previous_ns, const MapManagementOptions& options) {
  std::vector<std::int64_t> retired;
  for (const Landmark& landmark : estimate.landmarks()) {
    if (!landmark.passive && !seen.contains(landmark.track_id) &&
        seconds_between(landmark.last_seen_ns, t_ns) > options.rest_after_s) {
      retired.push_back(landmark.track_id);
    }
  }
  if (estimate.has_frozen() || !retired.empty() || estimate.layout().has_map_scale) {
    estimate.change_epoch(retired);
    convert_linear(estimate, previous_ns, options);
  }
}

}  // namespace

double linearity_index(const Estimate& estimate, const Landmark& landmark) {
  const Anchor* anchor = estimate.anchor_of(landmark);
  const double rho = landmark.value.z();
  if (anchor == nullptr) {
    return 0.0;
  }
  if (rho <= 0.0) {
    return std::numeric_limits<double>::infinity();
  }
  const double sigma_rho = sigma_of_inverse_depth(estimate, landmark);
  const Vector3d p_world_landmark = world_position(landmark, anchor);
  const Vector3d from_anchor = p_world_landmark - anchor->T_world_body * anchor->T_body_cam0.p;
  const Vector3d from_here = p_world_landmark - estimate.nav().T_world_body * anchor->T_body_cam0.p;
  const double distance = from_here.norm();
  const double cos_alpha = from_anchor.dot(from_here) / (from_anchor.norm() * distance);
  return 4.0 * sigma_rho / (rho * rho) / distance * std::abs(cos_alpha);
}

double projection_curvature(const Estimate& estimate, const Landmark& landmark, const MountedCamera& cam0) {
  const Anchor* anchor = estimate.anchor_of(landmark);
  const BodyPoint point = body_point_at_exposure(cam0, estimate.nav().T_world_body, landmark, anchor);
  const Eigen::RowVector3d axis = cam0.T_cam_body.R.row(2);
  const double depth = axis * point.Y + point.w * cam0.T_cam_body.p.z();
  const std::optional<PointProjection> projection = project_point(cam0, point);
  if (!projection || !(depth > 0.0)) {
    return std::numeric_limits<double>::infinity();
  }
  // Rows: u, v, homogeneous depth.
  std::vector<std::pair<Eigen::Index, Eigen::Matrix3d>> J(3);
  J[0].first = StateLayout::kPosition;
  J[0].second << projection->J_position, axis * point.J_Y_position;
  J[1].first = StateLayout::kAttitude;
  J[1].second << projection->J_attitude, axis * point.J_Y_attitude;
  J[2].first = landmark.at;
  J[2].second << projection->J_landmark,
      axis * point.J_Y_landmark + cam0.T_cam_body.p.z() * point.J_w_landmark;
  if (anchor != nullptr) {
    J.resize(5);
    J[3].first = anchor->position_at;
    J[3].second << projection->J_anchor_position, axis * point.J_Y_anchor_position;
    J[4].first = anchor->attitude_at;
    J[4].second << projection->J_anchor_attitude, axis * point.J_Y_anchor_attitude;
  }
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const auto& [row, J_row] : J) {
    for (const auto& [col, J_col] : J) {
      covariance += J_row * estimate.P().triplet_block(row, col) * J_col.transpose();
    }
  }
  const double pixel = std::sqrt(std::max(covariance(0, 0) + covariance(1, 1), 0.0));
  return pixel * std::sqrt(std::max(covariance(2, 2), 0.0)) / depth;
}

double depth_shift(const Estimate& estimate, const Landmark& landmark) {
  if (landmark.kind != LandmarkKind::kInverseDepth || landmark.rho_assumed <= 0.0) {
    return 0.0;
  }
  const double sigma = sigma_of_inverse_depth(estimate, landmark);
  const double shift = std::abs(landmark.value.z() - landmark.rho_assumed);
  return shift > sigma ? shift / landmark.rho_assumed : 0.0;
}

double depth_doubt(const Estimate& estimate, const Landmark& landmark) {
  if (landmark.kind == LandmarkKind::kCartesian) {
    return 0.0;
  }
  const double rho = landmark.value.z();
  return rho > 0.0 ? sigma_of_inverse_depth(estimate, landmark) / rho
                   : std::numeric_limits<double>::infinity();
}

std::size_t forget_misplaced(Estimate& estimate, const StereoFrame& frame, std::int64_t previous_ns,
                             const MountedCamera& cam0, const MapManagementOptions& options) {
  std::size_t forgotten = 0;
  for (const StereoObservation& observation : frame.observations) {
    Landmark* landmark = estimate.find(observation.track_id);
    if (landmark == nullptr) {
      continue;
    }
    const bool returns = landmark->last_seen_ns < previous_ns;
    const bool told = observation.in_cam1 && std::exchange(landmark->depth_guessed, false);
    if ((told && depth_doubt(estimate, *landmark) > options.known_depth) ||
        (returns && projection_curvature(estimate, *landmark, cam0) > options.max_curvature_px) ||
        depth_shift(estimate, *landmark) > options.max_depth_shift) {
      estimate.remove_landmark(observation.track_id);
      ++forgotten;
    }
  }
  return forgotten;
}

void update_active_set(Estimate& estimate, const StereoFrame& frame, std::int64_t previous_ns,
                       const MapManagementOptions& options, bool may_end) {
  if (may_end) {  // where an epoch is put off, so is this
    estimate.settle();
  }
  std::vector<std::int64_t> recalled;
  std::unordered_set<std::int64_t> seen;
  for (const StereoObservation& observation : frame.observations) {
    const Landmark* landmark = estimate.find(observation.track_id);
    if (landmark != nullptr && landmark->passive) {
      recalled.push_back(observation.track_id);
    }
    seen.insert(observation.track_id);
  }
  const double age = seconds_between(estimate.epoch_began_ns(), frame.t_ns);
  const bool full =
      estimate.has_frozen() && age > options.rest_after_s && estimate.grown_in_epoch() >= options.most_growth;
  if (may_end && (full || age >= options.epoch_s)) {
    end_epoch(estimate, seen, frame.t_ns, previous_ns, options);
  }
  estimate.recall(recalled);
}

void rest_unseen(Estimate& estimate, std::int64_t t_ns, const MapManagementOptions& options) {
  end_epoch(estimate, {}, t_ns, t_ns, options);
  estimate.settle_all();
}

std::size_t manage_map(Estimate& estimate, std::int64_t t_ns, const MapManagementOptions& options) {
  convert_linear(estimate, t_ns, options);
  const std::vector<std::int64_t> gone = to_remove(estimate, t_ns, options);
  for (const std::int64_t track_id : gone) {
    estimate.remove_landmark(track_id);
  }
  return gone.size();
}

}  // namespace limber
