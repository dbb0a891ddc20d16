// SPDX-License-Identifier: MIT
// A clock that steps while the start waits: docs/derivations/start.md.
#include <algorithm>
#include <cmath>
#include <utility>

#include "limber/core/so3.hpp"
#include "limber/core/time.hpp"
#include "start_window.hpp"
#include "window_pixels.hpp"

namespace limber::detail {

using Eigen::Vector3d;

namespace {

constexpr std::int64_t kLargestOffset = 300'000'000, kGrid = 5'000'000;  // [ns]
constexpr std::int64_t kSmallestOffset = 10'000'000;                     // [ns]
constexpr std::int64_t kRefine = 4'000'000;                              // [ns], of the last parabola
constexpr std::size_t kFewestTurns = 5;                                  // intervals on either side of a step
constexpr int kClockIterations = 25;
constexpr double kExplains = 1.6;  // of the least misfit

/// How the body turned between two frames, by images alone.
struct SeenTurn {
  std::int64_t begin_ns = 0, end_ns = 0;
  Vector3d rate;  // [rad/s], with the gyro's bias
};

std::vector<SeenTurn> turns_of(const WindowState& state, const Vector3d& bias) {
  std::vector<SeenTurn> out;
  for (std::size_t k = 1; k < state.frames.size(); ++k) {
    const NavigationState &from = state.frames[k - 1].nav, &to = state.frames[k].nav;
    const Vector3d turn = so3_log(from.T_world_body.R.transpose() * to.T_world_body.R);
    out.push_back({from.t_ns, to.t_ns, turn / seconds_between(from.t_ns, to.t_ns) + bias});
  }
  return out;
}

/// Squared difference to the gyro, whose stamps are late by that much [rad^2/s^2].
double mismatch(const InputBuffer& inputs, const SeenTurn& turn, std::int64_t offset_ns) {
  Vector3d sum = Vector3d::Zero();
  for (const InputStep& step : inputs.steps(turn.begin_ns + offset_ns, turn.end_ns + offset_ns)) {
    sum += step.dt * step.angular;
  }
  return (sum / seconds_between(turn.begin_ns, turn.end_ns) - turn.rate).squaredNorm();
}

/// Offset and interval (which ends with that frame) at which the gyro fits best; of the interval itself
/// nothing is asked.
struct ClockFit {
  std::size_t frame = 0;
  std::int64_t offset_ns = 0;
  double sum = kUnknown;
};

ClockFit best_clock(const InputBuffer& inputs, std::vector<SeenTurn> turns) {
  while (!turns.empty() && turns.back().end_ns + kLargestOffset > inputs.last_ns()) {
    turns.pop_back();
  }
  ClockFit best;
  std::vector<double> before = {0.0};  // sums of what the intervals before one mismatch as stamped
  for (const SeenTurn& turn : turns) {
    before.push_back(before.back() + mismatch(inputs, turn, 0));
  }
  for (std::int64_t offset = -kLargestOffset; offset <= kLargestOffset; offset += kGrid) {
    double after = 0.0;
    for (std::size_t k = turns.size(); k-- > kFewestTurns;) {
      const double sum = before[k] + after;
      if (turns.size() - k > kFewestTurns && sum < best.sum) {
        best = {k + 1, offset, sum};
      }
      after += mismatch(inputs, turns[k], offset);
    }
  }
  return best;
}

}  // namespace

/// The samples so far and their steps, once more, by what is known of their clock.
void StartWindow::read_inputs_anew() {
  inputs = InputBuffer();
  checks = InputChecks(limits_of(model.options.motion));
  for (const InputSample& sample : samples) {
    add_by_clock(sample);
  }
  (void)checks.take_counts();
  for (std::size_t k = 1; k < frames.size(); ++k) {
    frames[k].steps = inputs.steps(raw[k - 1].t_ns, raw[k].t_ns);
    frames[k].omega = frames[k].steps.empty() ? frames[k].omega : frames[k].steps.back().angular;
  }
}

/// The inputs of the window's frames, for states that were solved with others.
void StartWindow::take_inputs(WindowState& state) const {
  Frames now = kept();
  for (std::size_t k = 0; k < state.frames.size(); ++k) {
    now.frames[k].theta = state.frames[k].theta;
    now.frames[k].nav = state.frames[k].nav;
    state.frames[k] = std::move(now.frames[k]);
  }
}

void StartWindow::add_by_clock(InputSample sample) {
  if (const auto t_ns = taken_at(sample.t_ns, clock_step)) {
    sample.t_ns = *t_ns;
    checks.add(sample, inputs);
  }
}

/// The window solved with a clock that stepped so, from where images alone put its frames.
WindowState StartWindow::solved_with(const StampJump& step, WindowState state, WindowNormal& there) {
  clock_step = step;
  read_inputs_anew();
  take_inputs(state);
  for (WindowFrame& frame : state.frames) {
    frame.nav.bias_gyro = state.frames.front().nav.bias_gyro;
    frame.nav.bias_accel = state.frames.front().nav.bias_accel;
  }
  there = solve_window(model, state, kClockIterations);
  return state;
}

/// Once in a window the clock of the inputs may step.
bool StartWindow::explain_by_clock() {
  const bool jumped = clock_step && clock_step->jumps();
  if (model.options.motion != MotionModel::kImu || jumped || !agreed || !solution) {
    return false;
  }
  const std::optional<StampJump> as_it_was = clock_step;
  const std::int64_t offset_ns = clock_step ? clock_step->offset_ns : 0;
  // For a moment a step of the biases explains one of the clock, too.
  const std::optional<std::int64_t> bias_step_ns = std::exchange(stepped_before_ns, std::nullopt);
  const std::int64_t agreed_ns = agreed->solution.frames.back().nav.t_ns;
  const std::int64_t open_ns = std::min(agreed_ns, bias_step_ns.value_or(agreed_ns) - 1);
  WindowState open = *solution;
  for (WindowFrame& frame : open.frames) {
    if (frame.nav.t_ns > open_ns) {
      open_biases(frame);
    }
  }
  (void)solve_window(model, open, kClockIterations);
  const ClockFit best = best_clock(inputs, turns_of(open, agreed->solution.frames.front().nav.bias_gyro));
  if (best.sum == kUnknown || std::abs(best.offset_ns) < kSmallestOffset) {
    stepped_before_ns = bias_step_ns;
    return false;
  }
  StampJump found;
  WindowState state;
  WindowNormal there;
  double cost = kUnknown;
  const auto attempt = [&](std::size_t frame, std::int64_t by_ns) {
    const StampJump step{open.frames[frame - 1].nav.t_ns, open.frames[frame].nav.t_ns, offset_ns + by_ns,
                         offset_ns};
    WindowNormal now;
    WindowState solved = solved_with(step, open, now);
    const double cost_now = now.cost;
    if (cost_now < cost) {
      cost = cost_now;
      found = step;
      state = std::move(solved);
      there = std::move(now);
    }
    return cost_now;
  };
  std::size_t frame = best.frame;
  for (std::size_t k = best.frame - 1; k <= std::min(best.frame + 1, open.frames.size() - 1); ++k) {
    const double least = cost;
    attempt(k, best.offset_ns);
    frame = cost < least ? k : frame;
  }
  const double middle = cost, low = attempt(frame, best.offset_ns - kRefine),
               high = attempt(frame, best.offset_ns + kRefine), bend = low + high - 2.0 * middle;
  if (bend > 0.0) {
    const double shift = std::clamp(0.5 * (low - high) / bend, -2.0, 2.0);
    attempt(frame, best.offset_ns + std::llround(shift * static_cast<double>(kRefine)));
  }
  const Eigen::MatrixXd of_step = frame_covariance(there);
  if (of_step.size() == 0 || cost / expected_cost(model, state) > kExplains * least_misfit) {
    clock_step = as_it_was;
    read_inputs_anew();
    stepped_before_ns = bias_step_ns;
    return false;
  }
  clock_step = found;
  clock_sigma = 0.0;
  read_inputs_anew();
  solution = std::move(state);
  normal = std::move(there);
  covariance = of_step;
  return true;
}

}  // namespace limber::detail
