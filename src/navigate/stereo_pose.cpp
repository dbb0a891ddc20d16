// SPDX-License-Identifier: MIT
#include "stereo_pose.hpp"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "limber/core/median.hpp"
#include "limber/core/rotation_fit.hpp"
#include "limber/measure/triangulate.hpp"

namespace limber::detail {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr std::size_t kEnough = 10;
constexpr int kRounds = 4;
constexpr double kFar = 3.0;     // times the usual distance: a mismatch
constexpr double kExact = 0.02;  // of a depth: never taken for one

/// A point of the map, and where the cameras see it.
struct Seen {
  Vector3d world, body;
  double rho;  ///< [1/m]: far points know their depth less
};

std::vector<Seen> seen_in(const Estimate& map, const StereoFrame& frame, const MountedRig& rig) {
  const Pose T_cam1_cam0 = rig[1].T_cam_body * rig[0].T_cam_body.inverse();
  const Pose T_body_cam0 = rig[0].T_cam_body.inverse();
  std::vector<Seen> out;
  for (const StereoObservation& o : frame.observations) {
    const Landmark* landmark = o.in_cam0 && o.in_cam1 ? map.find(o.track_id) : nullptr;
    const auto d0 = landmark ? unproject(rig[0].camera, o.uv_cam0) : std::nullopt;
    const auto d1 = landmark ? unproject(rig[1].camera, o.uv_cam1) : std::nullopt;
    const auto rho = d0 && d1 ? inverse_depth_along(*d0, *d1, T_cam1_cam0) : std::nullopt;
    if (rho && *rho > 0.0) {
      out.push_back({map.landmark_position(*landmark), T_body_cam0 * Vector3d(*d0 / *rho), *rho});
    }
  }
  return out;
}

/// x_world = scale R x_body + p.
struct Similarity {
  Pose pose;
  double scale = 1.0;

  [[nodiscard]] double distance(const Seen& point) const {
    return (point.world - pose.p - scale * (pose.R * point.body)).norm() * point.rho;
  }
};

/// Least squares, weighted. [Umeyama1991]
Similarity fit(const std::vector<Seen>& points) {
  double weights = 0.0;
  Vector3d world = Vector3d::Zero(), body = Vector3d::Zero();
  for (const Seen& s : points) {
    const double weight = s.rho * s.rho;
    weights += weight;
    world += weight * s.world;
    body += weight * s.body;
  }
  world /= weights;
  body /= weights;
  Matrix3d covariance = Matrix3d::Zero();
  double spread = 0.0;
  for (const Seen& s : points) {
    const double weight = s.rho * s.rho;
    covariance += weight * (s.world - world) * (s.body - body).transpose();
    spread += weight * (s.body - body).squaredNorm();
  }
  const RotationFit turn = fit_rotation(covariance);
  Similarity out;
  out.pose.R = turn.R;
  out.scale = turn.agreement / spread;
  out.pose.p = world - out.scale * (out.pose.R * body);
  return out;
}

}  // namespace

std::optional<Pose> body_by_stereo(const Estimate& map, const StereoFrame& frame, const MountedRig& rig) {
  const std::vector<Seen> all = seen_in(map, frame, rig);
  std::vector<Seen> kept = all;
  Similarity found;
  for (int round = 0; round < kRounds; ++round) {
    if (kept.size() < kEnough) {
      return std::nullopt;
    }
    found = fit(kept);
    std::vector<double> distances;
    for (const Seen& point : all) {
      distances.push_back(found.distance(point));
    }
    const double most = kFar * std::max(upper_median(distances), kExact);
    kept.clear();
    for (std::size_t k = 0; k < all.size(); ++k) {
      if (distances[k] <= most) {
        kept.push_back(all[k]);
      }
    }
  }
  return found.pose;
}

}  // namespace limber::detail
