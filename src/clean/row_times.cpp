// SPDX-License-Identifier: MIT
#include "clean/row_times.hpp"

#include <utility>

#include "limber/core/time.hpp"

namespace limber::detail {
namespace {

constexpr double kLongestPathStep = 0.3;    // [s] between views that follow each other
constexpr double kShortestPathStep = 1e-3;  // [s]
constexpr std::size_t kPathViews = 3;       // a parabola: turns change within a frame

}  // namespace

RowTimes::RowTimes(const StereoCalibration& assumed)
    : cameras_{assumed.cam0, assumed.cam1}, readout_s_(assumed.readout_time_s) {}

RowTimes::View RowTimes::view(std::size_t camera, double stamp_s, const Eigen::Vector2d& uv) const {
  return {stamp_s + row_delay(cameras_[camera], readout_s_[camera], uv.y()), uv};
}

/// Views that are too far from each other in time for one path, or too close, begin anew.
void RowTimes::extend(Path& path, const View& view) {
  if (!path.empty()) {
    const double step = view.t - path.back().t;
    if (step > kLongestPathStep || step < kShortestPathStep) {
      path.clear();
    }
  }
  if (path.size() == kPathViews) {
    path.erase(path.begin());
  }
  path.push_back(view);
}

/// On the line or parabola through all views of the path (Lagrange).
Eigen::Vector2d RowTimes::place(const Path& path, double t) {
  Eigen::Vector2d out = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < path.size(); ++i) {
    double weight = 1.0;
    for (std::size_t j = 0; j < path.size(); ++j) {
      if (j != i) {
        weight *= (t - path[j].t) / (path[i].t - path[j].t);
      }
    }
    out += weight * path[i].uv;
  }
  return out;
}

/// A camera that sees the point anew takes the other one's motion. False where neither knows it.
bool RowTimes::refer(const Point& point, double stamp_s, StereoObservation& o) const {
  const std::array<bool, 2> seen = {o.in_cam0, o.in_cam1};
  const std::array<Eigen::Vector2d*, 2> uv = {&o.uv_cam0, &o.uv_cam1};
  for (std::size_t camera : {0, 1}) {
    if (!seen[camera]) {
      continue;
    }
    const bool own = point.paths[camera].size() > 1,
               other = seen[1 - camera] && point.paths[1 - camera].size() > 1;
    if (!own && !other) {
      return false;
    }
    const Path& path = point.paths[own ? camera : 1 - camera];
    *uv[camera] += place(path, stamp_s) - place(path, point.paths[camera].back().t);
  }
  return true;
}

std::size_t RowTimes::refer_to_stamp(StereoFrame& frame) {
  if (readout_s_ == std::array{0.0, 0.0}) {
    return 0;
  }
  origin_ns_ = origin_ns_.value_or(frame.t_ns);
  const double stamp_s = seconds_between(*origin_ns_, frame.t_ns);
  std::unordered_map<std::int64_t, Point> now;
  std::vector<StereoObservation> referred;
  for (StereoObservation& o : frame.observations) {
    const auto before = points_.find(o.track_id);
    Point& point = now[o.track_id];
    if (before != points_.end()) {
      point = std::move(before->second);
    }
    if (o.in_cam0) {
      extend(point.paths[0], view(0, stamp_s, o.uv_cam0));
    }
    if (o.in_cam1) {
      extend(point.paths[1], view(1, stamp_s, o.uv_cam1));
    }
    if (refer(point, stamp_s, o)) {
      referred.push_back(o);
    }
  }
  points_ = std::move(now);
  std::swap(frame.observations, referred);
  return referred.size() - frame.observations.size();
}

}  // namespace limber::detail
