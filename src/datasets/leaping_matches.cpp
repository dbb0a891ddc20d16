// SPDX-License-Identifier: MIT
#include "leaping_matches.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "limber/core/time.hpp"

namespace limber::detail {
namespace {

constexpr std::size_t kFewestLeaping = 5;  // points that leap together by no chance
constexpr double kLargestRatio = 1.5;      // of the parallax in two successive frames
constexpr double kLongestStep = 0.5;       // [s], after a longer one anything may have come near
constexpr double kNoise = 5e-3;            // [rad], about 3 px: a smaller change may be noise

using Parallaxes = std::unordered_map<std::int64_t, double>;  // by track [rad]

/// Angle between the bearings of a point in both cameras, as the assumed rig turns them.
std::optional<double> parallax(const StereoObservation& point, const StereoCalibration& calibration,
                               const Eigen::Matrix3d& R_cam1_cam0) {
  if (!point.in_cam0 || !point.in_cam1) {
    return std::nullopt;
  }
  const auto d0 = unproject(calibration.cam0, point.uv_cam0);
  const auto d1 = unproject(calibration.cam1, point.uv_cam1);
  if (!d0 || !d1) {
    return std::nullopt;
  }
  const Eigen::Vector3d turned = R_cam1_cam0 * *d0;
  return std::atan2(turned.cross(*d1).norm(), turned.dot(*d1));
}

Parallaxes parallaxes(const StereoFrame& frame, const StereoCalibration& calibration,
                      const Eigen::Matrix3d& R_cam1_cam0) {
  Parallaxes out;
  for (const StereoObservation& point : frame.observations) {
    if (const auto angle = parallax(point, calibration, R_cam1_cam0)) {
      out[point.track_id] = *angle;
    }
  }
  return out;
}

double ratio(double a, double b) { return std::max(a, b) / std::min(a, b); }

/// Tracks that leap between two frames, if most of those that both hold do so by more than noise; else none.
std::vector<std::int64_t> leaping(const Parallaxes& before, const Parallaxes& after) {
  std::vector<std::int64_t> out;
  std::size_t shared = 0, beyond_noise = 0;
  for (const auto& [track, angle] : after) {
    const auto it = before.find(track);
    if (it == before.end()) {
      continue;
    }
    ++shared;
    if (ratio(it->second, angle) > kLargestRatio) {
      out.push_back(track);
      beyond_noise += std::abs(it->second - angle) > kNoise ? 1 : 0;
    }
  }
  if (beyond_noise < kFewestLeaping || 2 * beyond_noise <= shared) {
    out.clear();
  }
  return out;
}

}  // namespace

std::size_t end_leaping_matches(std::vector<StereoFrame>& frames, const StereoCalibration& calibration) {
  const Eigen::Matrix3d R_cam1_cam0 = pose_from_rig(calibration.theta).R;
  std::unordered_set<std::int64_t> lost;
  Parallaxes before;
  std::int64_t before_ns = 0;
  for (StereoFrame& frame : frames) {
    Parallaxes now = parallaxes(frame, calibration, R_cam1_cam0);
    if (seconds_between(before_ns, frame.t_ns) <= kLongestStep) {
      for (const std::int64_t track : leaping(before, now)) {
        lost.insert(track);
      }
    }
    for (StereoObservation& point : frame.observations) {
      if (point.in_cam0 && lost.contains(point.track_id)) {
        point.in_cam1 = false;
      }
    }
    before = std::move(now);
    before_ns = frame.t_ns;
  }
  return lost.size();
}

}  // namespace limber::detail
