// SPDX-License-Identifier: MIT
#include "limber/diagnose/readout_watch.hpp"

#include <fmt/format.h>

#include <cmath>
#include <deque>
#include <set>
#include <utility>

#include "diagnose/clustered_regression.hpp"
#include "limber/core/time.hpp"
#include "limber/measure/epipolar.hpp"
#include "limber/measure/triangulate.hpp"
#include "measure/two_views.hpp"

namespace limber {
namespace {

constexpr double kApart = 0.2;         // [s] between the views of a pair
constexpr double kLongestApart = 0.4;  // [s]
constexpr double kLongestGap = 0.3;    // [s] between frames that follow each other
constexpr double kClusterSeconds = 1.0;
constexpr std::size_t kEnoughSeconds = 8, kEnoughViews = 50;
constexpr double kSurely = 6.0;           // standard deviations ...
constexpr double kLeastReadout = 2e-3;    // ... of at least that [s] ...
constexpr double kLeastExplained = 0.01;  // ... which explain that share of the residuals

}  // namespace

struct ReadoutWatch::State {
  /// A point of a frame: its place and depth, and how long before or after the stamp it was seen, for a
  /// readout of one second.
  struct SeenPoint {
    detail::MovingPoint at;
    double delay = 0.0;
  };

  struct SeenFrame {
    double t_s = 0.0;
    std::unordered_map<std::int64_t, SeenPoint> seen;
    detail::MovingPoints moving;  ///< those whose velocity is known
  };

  explicit State(const StereoCalibration& assumed)
      : calibration(assumed), T_cam1_cam0(pose_from_rig(assumed.theta)) {}

  [[nodiscard]] SeenFrame see(const StereoFrame& frame);
  void set_velocities();
  void compare();

  StereoCalibration calibration;
  Pose T_cam1_cam0;
  std::optional<std::int64_t> origin_ns;
  std::deque<SeenFrame> frames;  ///< the last one has no velocities yet
  detail::ClusteredRows rows;
  double squares = 0.0;
};

ReadoutWatch::State::SeenFrame ReadoutWatch::State::see(const StereoFrame& frame) {
  origin_ns = origin_ns.value_or(frame.t_ns);
  SeenFrame out{seconds_between(*origin_ns, frame.t_ns), {}, {}};
  for (const StereoObservation& o : frame.observations) {
    const auto bearing = o.in_cam0 ? unproject(calibration.cam0, o.uv_cam0) : std::nullopt;
    if (!bearing || !(bearing->z() > 0.0)) {
      continue;
    }
    SeenPoint& point = out.seen[o.track_id];
    point.at.place = bearing->hnormalized();
    point.delay = row_delay(calibration.cam0, 1.0, o.uv_cam0.y());
    if (const auto pair = detail::bearings(calibration, o)) {
      point.at.inverse_depth = inverse_depth_along(pair->cam0, pair->cam1.normalized(), T_cam1_cam0);
    }
  }
  return out;
}

/// Of the frame before the last one, between its neighbours.
void ReadoutWatch::State::set_velocities() {
  const SeenFrame &before = frames[frames.size() - 3], &after = frames.back();
  SeenFrame& now = frames[frames.size() - 2];
  const double dt = after.t_s - before.t_s;
  if (dt > 2.0 * kLongestGap) {
    return;
  }
  for (const auto& [id, point] : now.seen) {
    const auto a = before.seen.find(id), b = after.seen.find(id);
    if (a != before.seen.end() && b != after.seen.end()) {
      detail::MovingPoint& moving = now.moving[id] = point.at;
      // A second of readout moves the place at the stamp by minus the velocity times (v / height - 1/2).
      moving.slope = -point.delay / dt * (b->second.at.place - a->second.at.place);
    }
  }
}

/// The frame before the last one with the latest that is long enough before it.
void ReadoutWatch::State::compare() {
  const SeenFrame& now = frames[frames.size() - 2];
  while (frames.size() > 4 && now.t_s - frames[1].t_s >= kApart) {
    frames.pop_front();
  }
  const SeenFrame& from = frames.front();
  const double apart = now.t_s - from.t_s;
  if (apart < kApart || apart > kLongestApart) {
    return;
  }
  const auto pair =
      detail::parameter_between(from.moving, now.moving, calibration.cam0.fu, calibration.baseline());
  if (pair && pair->information > 0.0) {
    const double root = std::sqrt(pair->information);
    // What a lens leaves stays in its place: of a pixel's motion it makes the same part, however fast that
    // is.
    rows.A.emplace_back(Eigen::Vector2d(std::sqrt(static_cast<double>(pair->points)), root));
    rows.Z.push_back(rows.A.back());
    rows.y.push_back(pair->gradient / root);
    rows.cluster.push_back(static_cast<std::int64_t>(now.t_s / kClusterSeconds));
    squares += pair->squares;
  }
}

ReadoutWatch::ReadoutWatch(const StereoCalibration& assumed) : state_(std::make_unique<State>(assumed)) {}
ReadoutWatch::~ReadoutWatch() = default;
ReadoutWatch::ReadoutWatch(ReadoutWatch&&) noexcept = default;
ReadoutWatch& ReadoutWatch::operator=(ReadoutWatch&&) noexcept = default;

void ReadoutWatch::add(const StereoFrame& frame) {
  state_->frames.push_back(state_->see(frame));
  if (state_->frames.size() > 2) {
    state_->set_velocities();
    state_->compare();
  }
}

std::optional<ReadoutTime> ReadoutWatch::estimate() const {
  const detail::ClusteredRows& rows = state_->rows;
  const std::set<std::int64_t> clusters(rows.cluster.begin(), rows.cluster.end());
  if (rows.y.size() < kEnoughViews || clusters.size() < kEnoughSeconds) {
    return std::nullopt;
  }
  const auto solution = detail::solve(rows);
  if (!solution || std::abs(solution->x(1)) > kLongestReadout) {
    return std::nullopt;
  }
  double explained = 0.0;
  for (std::size_t k = 0; k < rows.y.size(); ++k) {
    const double left = rows.y[k] - rows.A[k].dot(solution->x);
    const double wrong_by = state_->calibration.readout_time_s[0] - solution->x(1);
    explained += std::pow(left - rows.A[k](1) * wrong_by, 2) - left * left;
  }
  return ReadoutTime{solution->x(1), solution->sigma_of_last(), explained / (explained + state_->squares)};
}

bool contradicts(const ReadoutTime& found, const StereoCalibration& assumed) {
  const double off = std::abs(found.seconds - assumed.readout_time_s[0]);
  return off > std::max(kLeastReadout, kSurely * found.sigma) && found.explains > kLeastExplained;
}

std::string in_words(const ReadoutTime& found, const StereoCalibration& assumed) {
  return fmt::format(
      "rolling shutter: the rows of an image are exposed one after the other, {:.1f} ± {:.1f} ms from the "
      "first to "
      "the last, and {:g} ms were assumed: --readout-time {:.4f}",
      1e3 * found.seconds, 1e3 * found.sigma, 1e3 * assumed.readout_time_s[0], found.seconds);
}

}  // namespace limber
