// SPDX-License-Identifier: MIT
#include <algorithm>
#include <map>
#include <utility>

#include "window_problem.hpp"

namespace limber::detail {

namespace {

// Standard deviations of steps: of one that is looked for in each interval, and of one that is there.
constexpr double kGyroAnywhere = 0.01, kAccelAnywhere = 0.1;  // [rad/s], [m/s^2]
constexpr double kGyroThere = 0.2, kAccelThere = 2.0;
constexpr double kBetter = 0.08;      // of the cost, that steps anywhere have to explain
constexpr double kPromises = 0.02;    // of the cost, by one linearisation: else it is not looked for
constexpr double kOneExplains = 0.7;  // of what they explain
/// Half of chi-square (six degrees of freedom) that one window in a million promises without a step. Where
/// pixels are far better than assumed, as of a rig at rest, shares of the cost mean nothing.
constexpr double kByChance = 19.2;
constexpr int kIterations = 25;
constexpr std::size_t kTried = 2;  // intervals, of those that a linearisation each chooses

double change(const WindowState& state, std::size_t k, Eigen::Vector3d NavigationState::*bias) {
  return (state.frames[k].nav.*bias - state.frames[k - 1].nav.*bias).norm();
}

/// The interval in which a bias changes most.
std::size_t most(const WindowState& state, Eigen::Vector3d NavigationState::*bias) {
  std::size_t out = 1;
  for (std::size_t k = 2; k < state.frames.size(); ++k) {
    out = change(state, k, bias) > change(state, out, bias) ? k : out;
  }
  return out;
}

WindowState opened(WindowState state, std::size_t k) {
  open_biases(state.frames[k]);
  return state;
}

/// The intervals in which one step of the biases promises most. Solutions with steps of some size everywhere
/// have smeared it over neighbours.
std::vector<std::size_t> best_intervals(const WindowModel& model, const WindowState& state,
                                        const WindowState& anywhere) {
  std::map<std::size_t, double> promises;
  for (const std::size_t middle :
       {most(anywhere, &NavigationState::bias_gyro), most(anywhere, &NavigationState::bias_accel)}) {
    for (std::size_t k = middle - 1; k <= middle + 1; ++k) {
      if (k > 0 && k < state.frames.size() && !promises.contains(k)) {
        promises[k] = promised_decrease(linearise(model, opened(state, k)));
      }
    }
  }
  std::vector<std::size_t> out;
  for (; out.size() < kTried && !promises.empty(); promises.erase(out.back())) {
    out.push_back(
        std::ranges::max_element(promises, {}, &std::pair<const std::size_t, double>::second)->first);
  }
  return out;
}

BiasStep with_step(const WindowModel& model, WindowState state, std::size_t k) {
  state = opened(std::move(state), k);
  BiasStep out;
  out.before_ns = state.frames[k].nav.t_ns;
  out.normal = solve_window(model, state, kIterations);
  out.state = std::move(state);
  return out;
}

}  // namespace

void open_biases(WindowFrame& frame) {
  frame.gyro_step = kGyroThere;
  frame.accel_step = kAccelThere;
}

std::optional<BiasStep> find_bias_step(const WindowModel& model, const WindowState& state,
                                       const WindowNormal& normal) {
  if (model.options.motion != MotionModel::kImu || state.frames.size() < 3) {
    return std::nullopt;
  }
  WindowState anywhere = state;
  for (WindowFrame& frame : anywhere.frames) {
    frame.gyro_step = std::max(frame.gyro_step, kGyroAnywhere);
    frame.accel_step = std::max(frame.accel_step, kAccelAnywhere);
  }
  if (!(promised_decrease(linearise(model, anywhere)) > std::max(kPromises * normal.cost, kByChance))) {
    return std::nullopt;
  }
  const double explained = normal.cost - solve_window(model, anywhere, kIterations).cost;
  if (!(explained > kBetter * normal.cost)) {
    return std::nullopt;
  }
  std::optional<BiasStep> best;
  for (const std::size_t k : best_intervals(model, state, anywhere)) {
    BiasStep step = with_step(model, state, k);
    if (!best || step.normal.cost < best->normal.cost) {
      best = std::move(step);
    }
  }
  if (!best || !(normal.cost - best->normal.cost > kOneExplains * explained)) {
    return std::nullopt;
  }
  return best;
}

}  // namespace limber::detail
