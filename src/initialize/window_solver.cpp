// SPDX-License-Identifier: MIT
#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "limber/core/factors.hpp"
#include "window_problem.hpp"

namespace limber::detail {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr double kDampingStart = 1e-4;
constexpr double kDampingMost = 1e8;
/// Decrease of the cost below which it stops: half of chi-square, so that no unknown is still off by more
/// than some hundredths of its standard deviation. Only of a step that damping hardly shortens: along what is
/// weakly known every other one is short.
constexpr double kPays = 1e-3;
/// Share of the promised decrease from which on the valley counts as straight.
constexpr double kStraight = 0.9;
constexpr double kUndamped = 1e-11;
constexpr double kDampingLeast = 1e-12;

/// W V^-1 for damped V.
MatrixXd times_inverse(const MatrixXd& W, const std::vector<Matrix3d>& V, double damping) {
  MatrixXd out(W.rows(), W.cols());
  for (std::size_t j = 0; j < V.size(); ++j) {
    Matrix3d damped = V[j];
    damped.diagonal() *= 1.0 + damping;
    out.middleCols<3>(static_cast<Index>(3 * j)).noalias() =
        W.middleCols<3>(static_cast<Index>(3 * j)) * damped.inverse();
  }
  return out;
}

/// W V^-1 Wᵀ, the lower triangle: what the points' elimination takes from A.
MatrixXd by_points(const WindowNormal& normal, const MatrixXd& WV) {
  MatrixXd out = MatrixXd::Zero(WV.rows(), WV.rows());
  if (WV.cols() > 0) {  // Eigen multiplies nothing at its peril
    add_lower_product(out, WV, transposed(normal.W));
  }
  return out;
}

struct Step {
  VectorXd frames, points;
};

std::optional<Step> step_of(const WindowNormal& normal, double damping) {
  const MatrixXd WV = times_inverse(normal.W, normal.V, damping);
  const FramesFactor factor(normal.A, damping, by_points(normal, WV), normal.layout);
  if (!factor.succeeded()) {
    return std::nullopt;
  }
  Step out;
  const std::vector<Index> rest = normal.layout.rest();
  VectorXd g = normal.g;
  g(rest) -= WV * normal.g_points;
  out.frames = factor.solve(g);
  const VectorXd of_rest = out.frames(rest);
  out.points = normal.g_points - normal.W.transpose() * of_rest;
  for (std::size_t j = 0; j < normal.V.size(); ++j) {
    Matrix3d damped = normal.V[j];
    damped.diagonal() *= 1.0 + damping;
    const auto at = static_cast<Index>(3 * j);
    out.points.segment<3>(at) = damped.inverse() * out.points.segment<3>(at).eval();
  }
  if (!out.frames.allFinite() || !out.points.allFinite()) {
    return std::nullopt;
  }
  return out;
}

/// Points moved by one Gauss-Newton step of their own, frames as they are. What scales a map bends in frames
/// and inverse depths together; in the frames alone it is straight, and steps along it need not be short.
WindowState points_refitted(const WindowModel& model, const WindowState& state, const WindowNormal& normal) {
  VectorXd points = VectorXd::Zero(normal.g_points.size());
  for (std::size_t j = 0; j < normal.V.size(); ++j) {
    const auto at = static_cast<Index>(3 * j);
    const Vector3d step = normal.V[j].inverse() * normal.g_points.segment<3>(at);
    if (step.allFinite()) {
      points.segment<3>(at) = step;
    }
  }
  return moved(model, state, VectorXd::Zero(normal.g.size()), points);
}

/// Decrease of the cost that a step promises, or less where it is damped.
double promised_decrease(const WindowNormal& normal, const Step& step) {
  return 0.5 * (normal.g.dot(step.frames) + normal.g_points.dot(step.points));
}

/// That of the undamped step.
double promised_decrease(const WindowNormal& normal) {
  const std::optional<Step> step = step_of(normal, 0.0);
  return step ? promised_decrease(normal, *step) : std::numeric_limits<double>::infinity();
}

}  // namespace

WindowNormal solve_window(const WindowModel& model, WindowState& state, int iterations) {
  WindowNormal normal = linearise(model, state);
  double damping = kDampingStart;
  for (int i = 0; i < iterations && damping < kDampingMost; ++i) {
    const std::optional<Step> step = step_of(normal, damping);
    if (!step) {
      damping *= 10.0;
      continue;
    }
    WindowState next = moved(model, state, step->frames, step->points);
    WindowNormal there = linearise(model, next);
    if (!(normal.cost - there.cost >= kStraight * promised_decrease(normal, *step))) {
      WindowState refitted = points_refitted(model, next, there);
      WindowNormal at_refitted = linearise(model, refitted);
      if (at_refitted.cost < there.cost) {
        next = std::move(refitted);
        there = std::move(at_refitted);
      }
    }
    if (!(there.cost < normal.cost)) {
      damping *= 10.0;
      continue;
    }
    const double gained = normal.cost - there.cost;
    state = std::move(next);
    normal = std::move(there);
    if (gained < kPays) {
      normal.left = promised_decrease(normal);
      if (damping <= kUndamped || normal.left < kPays) {
        return normal;
      }
    }
    damping = std::max(damping * 0.1, kDampingLeast);
  }
  normal.left = promised_decrease(normal);
  return normal;
}

MatrixXd frame_covariance(const WindowNormal& normal) {
  const MatrixXd WV = times_inverse(normal.W, normal.V, 0.0);
  MatrixXd S = normal.A;
  subtract_of_rest(S, by_points(normal, WV), normal.layout);
  const Cholesky llt(std::move(S));
  if (!llt.succeeded()) {
    return {};
  }
  return llt.inverse();
}

}  // namespace limber::detail
