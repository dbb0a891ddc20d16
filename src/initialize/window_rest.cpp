// SPDX-License-Identifier: MIT
// A start that waits for the body to move keeps the last seconds of its rest.
#include <algorithm>
#include <cstdint>
#include <vector>

#include "start_window.hpp"

namespace limber::detail {

using Eigen::Index;

namespace {

constexpr double kLongestRest = 5.0;  // [s] of a window in which nothing moves
constexpr double kKeptRest = 2.5;     // [s]: biases, and where the points are

}  // namespace

bool StartWindow::awaits_motion() const {
  return solution && !moves() && leaves_scale_open() && has_scale(model.options.motion) &&
         !(scale_sigma() <= options.open_scale_sigma);
}

/// A window that is long enough begins later. What it says of the frames before is kept, in the world of
/// those that stay: the origin is where the body was in the first of them.
void StartWindow::forget_rest() {
  if (length() < kLongestRest) {
    return;
  }
  const std::vector<WindowFrame>& solved = solution->frames;
  const auto first = std::find_if(solved.begin(), solved.end() - 1, [&](const WindowFrame& frame) {
    return seconds_between(frame.nav.t_ns, raw.back().t_ns) <= kKeptRest;
  });
  const NavigationState origin = first->nav;
  const Index at = static_cast<Index>(first - solved.begin()) * model.frame_size();
  const Eigen::Matrix<double, 6, 6> more = covariance.block<6, 6>(at, at);
  const auto is_dropped = [&](std::int64_t t_ns) { return t_ns < origin.t_ns; };

  rested = trajectory();
  std::erase_if(rested, [&](const SmoothedState& state) { return !is_dropped(state.nav.t_ns); });
  for (SmoothedState& state : rested) {
    state.nav.T_world_body.p -= origin.T_world_body.p;
    state.pose_covariance += 0.5 * (more + more.transpose());
  }
  std::erase_if(raw, [&](const StereoFrame& frame) { return is_dropped(frame.t_ns); });
  std::erase_if(frames, [&](const WindowFrame& frame) { return is_dropped(frame.nav.t_ns); });
  frames.front().steps.clear();
  std::erase_if(samples, [&](const InputSample& sample) {
    return seconds_between(sample.t_ns, origin.t_ns) > kKeptRest;
  });
  if (stepped_before_ns && *stepped_before_ns <= origin.t_ns) {
    stepped_before_ns.reset();
  }
  R_first = origin.T_world_body.R;
  agreed.reset();
  solve();
  (void)disagrees();
}

}  // namespace limber::detail
