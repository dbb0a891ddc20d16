// SPDX-License-Identifier: MIT
#include "tracks.hpp"

#include <algorithm>
#include <map>
#include <optional>

#include "limber/core/time.hpp"
#include "limber/sensors/camera.hpp"

namespace limber::detail {

using Eigen::Vector3d;

namespace {

constexpr double kNearestBaselines = 0.5, kFarthestBaselines = 1000.0;  // where a point may start

/// The chart points along the first left bearing.
Landmark landmark_along(std::int64_t track_id, const Vector3d& bearing) {
  Landmark out;
  out.track_id = track_id;
  out.R_cam0_chart.col(2) = bearing;
  out.R_cam0_chart.col(0) = bearing.unitOrthogonal();
  out.R_cam0_chart.col(1) = bearing.cross(out.R_cam0_chart.col(0));
  return out;
}

bool says_something(const Track& track, bool lone_frames) {
  return track.sights.size() >= 2 && (lone_frames || track.sights.front().frame != track.sights.back().frame);
}

/// How long the point had been away when it came back in frame n [s]; 0 if it was seen in the frame before.
double absence(const Track& track, std::span<const StereoFrame> frames, std::size_t n) {
  const std::size_t last = track.sights.back().frame;
  return last + 1 >= n ? 0.0 : seconds_between(frames[last].t_ns, frames[n - 1].t_ns);
}

/// Sums of the linear least squares d × (R d0 + rho t) = 0.
struct DepthSums {
  double numerator = 0.0, denominator = 0.0;

  void add(const Vector3d& d, const Vector3d& turned, const Vector3d& t) {
    const Vector3d along = d.cross(t);
    numerator -= along.dot(d.cross(turned));
    denominator += along.squaredNorm();
  }
};

}  // namespace

std::size_t Track::used() const {
  return static_cast<std::size_t>(
      std::count_if(sights.begin(), sights.end(), [](const Sight& sight) { return !sight.refused; }));
}

Eigen::Vector2d Track::first_left() const {
  return std::find_if(sights.begin(), sights.end(), [](const Sight& sight) { return sight.camera == 0; })->uv;
}

std::vector<Track> gather_tracks(std::span<const StereoFrame> frames, const MountedRig& rig,
                                 double forget_after_s, bool lone_frames) {
  std::vector<Track> tracks;
  std::map<std::int64_t, std::size_t> current;  // track of an id
  for (std::size_t n = 0; n < frames.size(); ++n) {
    for (const StereoObservation& seen : frames[n].observations) {
      auto it = current.find(seen.track_id);
      if (it != current.end() && absence(tracks[it->second], frames, n) > forget_after_s) {
        current.erase(it);
        it = current.end();
      }
      if (it == current.end()) {
        const auto bearing = seen.in_cam0 ? unproject(rig[0].camera, seen.uv_cam0) : std::nullopt;
        if (!bearing) {
          continue;
        }
        it = current.emplace(seen.track_id, tracks.size()).first;
        tracks.push_back({n, landmark_along(seen.track_id, *bearing), {}});
      }
      std::vector<Sight>& sights = tracks[it->second].sights;
      if (seen.in_cam0) {
        sights.push_back({n, 0, seen.uv_cam0});
      }
      if (seen.in_cam1) {
        sights.push_back({n, 1, seen.uv_cam1});
      }
    }
  }
  std::erase_if(tracks, [&](const Track& track) { return !says_something(track, lone_frames); });
  return tracks;
}

void triangulate(Track& track, std::span<const Pose> T_world_body, const MountedRig& rig, bool trust_rig) {
  const Pose T_world_anchor = T_world_body[track.anchor] * rig[0].T_cam_body.inverse();
  const Vector3d d0 = track.landmark.R_cam0_chart.col(2);
  DepthSums left, right;
  for (const Sight& sight : track.sights) {
    const MountedCamera& camera = rig[static_cast<std::size_t>(sight.camera)];
    const std::optional<Vector3d> d = unproject(camera.camera, sight.uv);
    if (d && !sight.refused && !(sight.camera == 0 && sight.frame == track.anchor)) {
      const Pose T = camera.T_cam_body * T_world_body[sight.frame].inverse() * T_world_anchor;
      (sight.camera == 0 ? left : right).add(*d, T.R * d0, T.p);
    }
  }
  const bool left_alone = !trust_rig && left.denominator > right.denominator;
  const double numerator = left.numerator + (left_alone ? 0.0 : right.numerator);
  const double denominator = left.denominator + (left_alone ? 0.0 : right.denominator);
  const double baseline = (rig[1].T_cam_body * rig[0].T_cam_body.inverse()).p.norm();
  const double rho = denominator > 0.0 ? numerator / denominator : 0.0;
  track.landmark.value << 0.0, 0.0,
      std::clamp(rho, 1.0 / (kFarthestBaselines * baseline), 1.0 / (kNearestBaselines * baseline));
}

}  // namespace limber::detail
