// SPDX-License-Identifier: MIT
#include "clean/still_points.hpp"

#include <algorithm>
#include <optional>

#include "limber/core/median.hpp"
#include "limber/core/so3.hpp"
#include "limber/sensors/camera.hpp"
#include "measure/two_views.hpp"

namespace limber::detail {
namespace {

constexpr double kStill = 2.5;   // farther from its place no point that goes with the camera is seen [px]
constexpr double kMoved = 25.0;  // by the turn of the view: what a point of the world would have gone [px]
constexpr double kLater = 1.5;   // times the way of the test before: a shift undoes a turn for a moment only
constexpr std::size_t kFewestFollowed = 10;

StereoFrame without(const StereoFrame& frame, const std::unordered_set<std::int64_t>& tracks) {
  StereoFrame out = frame;
  remove_tracks(out, tracks);
  return out;
}

}  // namespace

StillPoints::StillPoints(const StereoCalibration& assumed) : assumed_(assumed) {}

void StillPoints::compare_with(const StereoFrame& frame) {
  first_ = frame;
  next_test_ = kMoved;
  most_moving_ = 0;
  compared_.clear();
  for (const StereoObservation& point : frame.observations) {
    if (point.in_cam0) {
      compared_[point.track_id] = {point.uv_cam0, 0.0, true};
    }
  }
}

void StillPoints::follow(const StereoFrame& frame) {
  for (auto& [id, track] : compared_) {
    track.followed = false;
  }
  for (const StereoObservation& point : frame.observations) {
    const auto it = compared_.find(point.track_id);
    if (it != compared_.end() && point.in_cam0) {
      it->second.followed = true;
      it->second.strayed = std::max(it->second.strayed, (point.uv_cam0 - it->second.uv).norm());
    }
  }
}

std::unordered_set<std::int64_t> StillPoints::suspects() const {
  std::unordered_set<std::int64_t> out;
  for (const auto& [id, track] : compared_) {
    if (track.followed && track.strayed <= kStill) {
      out.insert(id);
    }
  }
  return out;
}

/// Of the points that are no suspects and still followed [px].
std::vector<double> StillPoints::ways() const {
  std::vector<double> out;
  for (const auto& [id, track] : compared_) {
    if (track.followed && track.strayed > kStill) {
      out.push_back(track.strayed);
    }
  }
  return out;
}

/// Suspects whose bearing the turn of the view, as the others have it, would have taken far from their place.
std::vector<std::int64_t> StillPoints::turned_away(const StereoFrame& frame) const {
  const std::unordered_set<std::int64_t> all = suspects();
  if (all.empty()) {
    return {};
  }
  const auto motion = left_motion(assumed_, without(first_, all), without(frame, all));
  if (!motion) {
    return {};
  }
  const Eigen::Matrix3d R = so3_exp(-assumed_.T_body_cam0.R.transpose() * motion->turn);
  std::vector<std::int64_t> out;
  for (const std::int64_t id : all) {
    const Eigen::Vector2d& uv = compared_.at(id).uv;
    const auto bearing = unproject(assumed_.cam0, uv);
    const auto turned = bearing ? project(assumed_.cam0, R * *bearing) : std::nullopt;
    if (turned && (turned->uv - uv).norm() >= kMoved) {
      out.push_back(id);
    }
  }
  std::ranges::sort(out);
  return out;
}

std::vector<std::int64_t> StillPoints::end(StereoFrame& frame) {
  remove_tracks(frame, known_);
  follow(frame);
  std::vector<double> ways = this->ways();
  const std::size_t moving = ways.size();
  most_moving_ = std::max(most_moving_, moving);
  std::vector<std::int64_t> found;
  if (moving >= kFewestFollowed) {
    const double usual = upper_median(std::move(ways));
    if (usual >= next_test_) {
      next_test_ = kLater * usual;
      for (const std::int64_t id : turned_away(frame)) {
        if (!accused_.insert(id).second) {
          found.push_back(id);
        }
      }
    }
  }
  known_.insert(found.begin(), found.end());
  remove_tracks(frame, known_);
  const bool too_few = moving < kFewestFollowed || 2 * moving < most_moving_;
  if (compared_.size() < kFewestFollowed || (most_moving_ >= kFewestFollowed && too_few)) {
    compare_with(frame);
  }
  return found;
}

}  // namespace limber::detail
