// SPDX-License-Identifier: MIT
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "points_elimination.hpp"
#include "window_problem.hpp"

namespace limber::detail {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double kDampingStart = 1e-4;
constexpr double kDampingMost = 1e8;
constexpr double kMoreDamping = 10.0;
/// Where the valley is straight and no step has failed yet.
constexpr double kLessDamping = 1e3;
/// Decrease of the cost below which it stops: half of chi-square, so that no unknown is still off by more
/// than some hundredths of its standard deviation. Only of a step that damping hardly shortens: along what is
/// weakly known every other one is short.
constexpr double kPays = 1e-3;
/// Share of the promised decrease from which on the valley counts as straight.
constexpr double kStraight = 0.9;
constexpr double kLonger = 1.5, kLongestStep = 8.0;  // of a step: what is tried, at most
constexpr double kUndamped = 1e-11;
constexpr double kDampingLeast = 1e-12;

struct Step {
  VectorXd frames, points;
};

std::optional<Step> step_of(const WindowNormal& normal, double damping) {
  const PointsElimination points(normal, damping);
  const FramesFactor factor(normal.A, damping, points.from_matrix(), normal.layout);
  if (!factor.succeeded()) {
    return std::nullopt;
  }
  const std::vector<Index> rest = normal.layout.rest();
  VectorXd g = normal.g;
  g(rest) -= points.from_gradient();
  Step out;
  out.frames = factor.solve(g);
  out.points = points.step(out.frames(rest));
  if (!out.frames.allFinite() || !out.points.allFinite()) {
    return std::nullopt;
  }
  return out;
}

/// Points moved by one Gauss-Newton step of their own, frames as they are. What scales a map bends in frames
/// and inverse depths together; in the frames alone it is straight, and steps along it need not be short.
WindowState points_refitted(const WindowModel& model, const WindowState& state, const WindowNormal& normal) {
  VectorXd points = PointsElimination(normal, 0.0).step_alone();
  for (Index at = 0; at < points.size(); at += 3) {
    if (!points.segment<3>(at).allFinite()) {
      points.segment<3>(at).setZero();
    }
  }
  return moved(model, state, VectorXd::Zero(normal.g.size()), points);
}

/// Decrease of the cost that a step promises, or less where it is damped.
double promised_decrease(const WindowNormal& normal, const Step& step) {
  return 0.5 * (normal.g.dot(step.frames) + normal.g_points.dot(step.points));
}

/// An undamped step that was taken, and the direction in which.
struct Taken {
  Step step, direction;
  double promised = 0.0;
};

/// Conjugate to the direction before (Polak and Ribiere), with Gauss-Newton's steps as gradients. Along what
/// is weakly known the residuals' own curvature, which Gauss-Newton leaves out, may undo most of the
/// information: its steps are then short by as much, one after the other.
Step conjugate(const WindowNormal& normal, const Step& step, const std::optional<Taken>& before) {
  if (!before) {
    return step;
  }
  const double beta =
      (promised_decrease(normal, step) - promised_decrease(normal, before->step)) / before->promised;
  return beta > 0.0 ? Step{step.frames + beta * before->direction.frames,
                           step.points + beta * before->direction.points}
                    : step;
}

struct Trial {
  WindowState state;
  WindowNormal normal;
  bool straight = true;  ///< the step gained what it promised
};

Trial trial_at(const WindowModel& model, WindowState state, WindowNormal& spare) {
  sum_up_inputs(model, state);
  WindowNormal normal = linearise(model, state, std::exchange(spare, {}));
  return {std::move(state), std::move(normal)};
}

/// How many steps on the parabola through the cost, its slope and the cost after one step is lowest.
double lowest_along(double promised, double gained) {
  return promised / std::max(2.0 * promised - gained, promised / kLongestStep);
}

/// Where a step leads: as it is, or further on where the cost still falls there, or with the points fitted
/// anew where it is not as low as promised.
/// @param spare memory for normal equations
Trial best_after(const WindowModel& model, const WindowState& state, const WindowNormal& normal,
                 const Step& step, std::array<WindowNormal, 2>& spare) {
  const double promised = promised_decrease(normal, step);
  Trial out = trial_at(model, moved(model, state, step.frames, step.points), spare[0]);
  const double gained = normal.cost - out.normal.cost;
  out.straight = gained >= kStraight * promised;
  const double length = out.straight ? lowest_along(promised, gained) : 1.0;
  if (out.straight && length < kLonger) {
    return out;
  }
  Trial other = trial_at(model,
                         out.straight ? moved(model, state, length * step.frames, length * step.points)
                                      : points_refitted(model, out.state, out.normal),
                         spare[1]);
  other.straight = out.straight;
  if (other.normal.cost < out.normal.cost) {
    std::swap(out, other);
  }
  spare[1] = std::move(other.normal);
  return out;
}

WindowNormal come_down(const WindowModel& model, WindowState& state, int iterations) {
  WindowNormal normal = linearise(model, state);
  double damping = kDampingStart;
  std::optional<Taken> before;
  std::array<WindowNormal, 2> spare;
  bool failed = false;
  for (int i = 0; i < iterations && damping < kDampingMost; ++i) {
    std::optional<Step> step = step_of(normal, damping);
    if (!step) {
      damping *= kMoreDamping;
      continue;
    }
    Step direction = conjugate(normal, *step, before);
    Trial next = best_after(model, state, normal, direction, spare);
    const double gained = normal.cost - next.normal.cost;
    if (!(gained > 0.0)) {
      damping *= before ? 1.0 : kMoreDamping;
      before.reset();
      spare[0] = std::move(next.normal);
      failed = true;
      continue;
    }
    before.reset();
    if (damping <= kUndamped) {
      const double promised = promised_decrease(normal, *step);
      before = Taken{*std::move(step), std::move(direction), promised};
    }
    state = std::move(next.state);
    spare[0] = std::exchange(normal, std::move(next.normal));
    if (gained < kPays) {
      normal.left = promised_decrease(normal);
      if (damping <= kUndamped || normal.left < kPays) {
        return normal;
      }
    }
    damping = std::max(damping / (next.straight && !failed ? kLessDamping : kMoreDamping), kDampingLeast);
  }
  normal.left = promised_decrease(normal);
  return normal;
}

}  // namespace

double promised_decrease(const WindowNormal& normal) {
  const std::optional<Step> step = step_of(normal, 0.0);
  return step ? promised_decrease(normal, *step) : std::numeric_limits<double>::infinity();
}

WindowNormal solve_window(const WindowModel& model, WindowState& state, int iterations) {
  sum_up_inputs(model, state);
  WindowNormal out = come_down(model, state, iterations);
  forget_sums(state);
  return out;
}

MatrixXd frame_covariance(const WindowNormal& normal) {
  const FramesFactor factor(normal.A, 0.0, PointsElimination(normal, 0.0).from_matrix(), normal.layout);
  if (!factor.succeeded()) {
    return {};
  }
  const MatrixXd inverse = factor.inverse();
  return 0.5 * (inverse + inverse.transpose());
}

}  // namespace limber::detail
