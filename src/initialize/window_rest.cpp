// SPDX-License-Identifier: MIT
// A start that waits for the body to move keeps the last seconds of its rest.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "limber/core/median.hpp"
#include "start_window.hpp"

namespace limber::detail {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

namespace {

constexpr double kLongestRest = 5.0;    // [s] of a window in which nothing moves
constexpr double kKeptRest = 2.5;       // [s]: biases, and where the points are
constexpr double kStill = 3.0;          // [px], of the usual point: more is a motion or a turn
constexpr std::size_t kFewPoints = 10;  // say nothing
constexpr double kSameWay = 0.5;        // of two ways through the same frames, cosine

using L = StateLayout;

/// How far the usual point is from where it was [px]; nothing if few are seen in both frames.
std::optional<double> usual_shift(const StereoFrame& before, const StereoFrame& now) {
  std::unordered_map<std::int64_t, Eigen::Vector2d> known;
  for (const StereoObservation& point : before.observations) {
    if (point.in_cam0) {
      known.emplace(point.track_id, point.uv_cam0);
    }
  }
  std::vector<double> shifts;
  for (const StereoObservation& point : now.observations) {
    if (const auto at = known.find(point.track_id); at != known.end() && point.in_cam0) {
      shifts.push_back((point.uv_cam0 - at->second).norm());
    }
  }
  return shifts.size() < kFewPoints ? std::nullopt : std::optional(upper_median(std::move(shifts)));
}

/// How a body's errors follow those of the origin, position and yaw: body_size × 4. (A start by odometry has
/// no window, all others have a velocity.)
MatrixXd by_origin(const NavigationState& nav, Index body_size) {
  const Vector3d up = Vector3d::UnitZ();
  MatrixXd J = MatrixXd::Zero(body_size, 4);
  J.block<3, 3>(L::kPosition, 0).setIdentity();
  J.block<3, 1>(L::kPosition, 3) = up.cross(nav.T_world_body.p);
  J.block<3, 1>(L::kAttitude, 3) = nav.T_world_body.R.transpose() * up;
  J.block<3, 1>(L::kVelocity, 3) = up.cross(nav.v_world_body);
  return J;
}

/// Position and yaw of a pose's errors.
Matrix4d of_origin(const Matrix3d& R, const Eigen::Matrix<double, 6, 6>& pose) {
  Eigen::Matrix<double, 4, 6> J = Eigen::Matrix<double, 4, 6>::Zero();
  J.topLeftCorner<3, 3>().setIdentity();
  J.bottomRightCorner<1, 3>() = R.row(2);
  return J * pose * J.transpose();
}

}  // namespace

MatrixXd StartWindow::seen_from_first(const RestSeenSince& since, const NavigationState& nav,
                                      const MatrixXd& P) const {
  MatrixXd J = by_origin(nav, P.rows());
  J.leftCols<3>() *= std::max(since.growth, 1.0);
  MatrixXd out = P + J * origin * J.transpose();
  out.topLeftCorner<3, 3>().diagonal().array() += since.apart;
  return out;
}

/// A window that is not full yet, and whose solution would be the last one again.
bool StartWindow::still_rests() const {
  if (!rests || length() >= kLongestRest) {
    return false;
  }
  const std::optional<double> shift = usual_shift(raw.front(), raw.back());
  return shift && *shift < kStill;
}

bool StartWindow::awaits_motion() const {
  return solution && !moves() && is_over_by_motion() && !(scale_sigma() <= options.open_scale_sigma);
}

/// Where nothing told the scale when a rest was dropped, its poses have any. Frames that stayed have been
/// solved again since, which tells a factor, if they go the same way, and how wrong the poses are beside it.
RestSeenSince StartWindow::rest_seen_since() const {
  double now_then = 0.0, then_then = 0.0, now_now = 0.0, count = 0.0;
  auto then = stayed.begin();
  for (const WindowFrame& frame : solution->frames) {
    while (then != stayed.end() && then->nav.t_ns < frame.nav.t_ns) {
      ++then;
    }
    if (then == stayed.end()) {
      break;
    }
    if (then->nav.t_ns == frame.nav.t_ns) {
      const Vector3d &p = frame.nav.T_world_body.p, &p_then = then->nav.T_world_body.p;
      now_then += p.dot(p_then);
      then_then += p_then.squaredNorm();
      now_now += p.squaredNorm();
      count += 1.0;
    }
  }
  if (then_then == 0.0) {
    return {};
  }
  const bool same_way = now_then > kSameWay * std::sqrt(then_then * now_now);
  const double growth = same_way ? now_then / then_then : 1.0;
  return {growth, (now_now - 2.0 * growth * now_then + growth * growth * then_then) / count};
}

/// The poses of a rest that was dropped, in the scale of the window as it is now.
std::vector<SmoothedState> StartWindow::rested_by_scale(const RestSeenSince& since) const {
  std::vector<SmoothedState> out = rested;
  const double wider = std::max(since.growth, 1.0);
  for (SmoothedState& state : out) {
    state.nav.T_world_body.p *= since.growth;
    state.nav.v_world_body *= since.growth;
    state.pose_covariance.topRows<3>() *= wider;
    state.pose_covariance.leftCols<3>() *= wider;
    state.pose_covariance.topLeftCorner<3, 3>().diagonal().array() += since.apart;
    state.motion_covariance.topRows<3>() *= wider;
    state.motion_covariance.leftCols<3>() *= wider;
  }
  return out;
}

/// A window that is long enough begins later. What it says of the frames before is kept, in the world of
/// those that stay: its origin is where the body was in the first of them, and as sure as that.
void StartWindow::forget_rest() {
  if (length() < kLongestRest) {
    return;
  }
  if (knows_no_scale()) {
    take_scale_of_rig();
    of_rig.reset();
  }
  const std::vector<WindowFrame>& solved = solution->frames;
  const auto first = std::find_if(solved.begin(), solved.end() - 1, [&](const WindowFrame& frame) {
    return seconds_between(frame.nav.t_ns, raw.back().t_ns) <= kKeptRest;
  });
  const NavigationState begin = first->nav;
  const auto is_dropped = [&](std::int64_t t_ns) { return t_ns < begin.t_ns; };

  std::vector<SmoothedState> states = trajectory();
  const auto kept = std::find_if(states.begin(), states.end(),
                                 [&](const SmoothedState& state) { return !is_dropped(state.nav.t_ns); });
  origin = of_origin(begin.T_world_body.R, kept->pose_covariance);
  for (SmoothedState& state : states) {
    state.nav.T_world_body.p -= begin.T_world_body.p;
  }
  rested.assign(states.begin(), kept);
  stayed.assign(kept, states.end());
  std::erase_if(raw, [&](const StereoFrame& frame) { return is_dropped(frame.t_ns); });
  std::erase_if(frames, [&](const WindowFrame& frame) { return is_dropped(frame.nav.t_ns); });
  frames.front().steps.clear();
  std::erase_if(samples, [&](const InputSample& sample) {
    return seconds_between(sample.t_ns, begin.t_ns) > kKeptRest;
  });
  if (stepped_before_ns && *stepped_before_ns <= begin.t_ns) {
    stepped_before_ns.reset();
  }
  R_first = begin.T_world_body.R;
  agreed.reset();
  solve();
  (void)disagrees();
}

}  // namespace limber::detail
