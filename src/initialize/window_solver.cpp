// SPDX-License-Identifier: MIT
#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <optional>

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

/// Rows of W that are not zero: poses and theta; points say nothing of velocities and biases.
std::vector<Index> seen_by_points(const MatrixXd& W) {
  const VectorXd largest = W.cols() > 0 ? VectorXd(W.cwiseAbs().rowwise().maxCoeff()) : VectorXd();
  std::vector<Index> rows;
  for (Index k = 0; k < largest.size(); ++k) {
    if (largest[k] > 0.0) {
      rows.push_back(k);
    }
  }
  return rows;
}

/// A - W V^-1 Wᵀ, lower triangle.
MatrixXd without_points(const WindowNormal& normal, const MatrixXd& WV, double damping) {
  MatrixXd S = normal.A;
  S.diagonal() *= 1.0 + damping;
  const std::vector<Index> rows = seen_by_points(normal.W);
  if (rows.empty()) {  // Eigen multiplies nothing at its peril
    return S;
  }
  const auto n = static_cast<Index>(rows.size());
  const MatrixXd W = normal.W(rows, Eigen::all);
  MatrixXd known = MatrixXd::Zero(n, n);
  add_lower_product(known, WV(rows, Eigen::all), transposed(W));
  for (Index j = 0; j < n; ++j) {
    for (Index i = j; i < n; ++i) {
      S(rows[static_cast<std::size_t>(i)], rows[static_cast<std::size_t>(j)]) -= known(i, j);
    }
  }
  return S;
}

struct Step {
  VectorXd frames, points;
};

std::optional<Step> step_of(const WindowNormal& normal, double damping) {
  const MatrixXd WV = times_inverse(normal.W, normal.V, damping);
  const FramesFactor factor(without_points(normal, WV, damping), normal.layout);
  if (!factor.succeeded()) {
    return std::nullopt;
  }
  Step out;
  out.frames = factor.solve(normal.g - WV * normal.g_points);
  out.points = normal.g_points - normal.W.transpose() * out.frames;
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
  const Cholesky llt(without_points(normal, WV, 0.0));
  if (!llt.succeeded()) {
    return {};
  }
  return llt.inverse();
}

}  // namespace limber::detail
