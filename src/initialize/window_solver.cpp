// SPDX-License-Identifier: MIT
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <optional>

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

/// A - W V^-1 Wᵀ, lower triangle.
MatrixXd without_points(const WindowNormal& normal, const MatrixXd& WV, double damping) {
  MatrixXd S = normal.A;
  S.diagonal() *= 1.0 + damping;
  if (WV.cols() > 0) {  // Eigen multiplies nothing at its peril
    S.triangularView<Eigen::Lower>() -= WV * normal.W.transpose();
  }
  return S;
}

struct Step {
  VectorXd frames, points;
};

std::optional<Step> step_of(const WindowNormal& normal, double damping) {
  const MatrixXd WV = times_inverse(normal.W, normal.V, damping);
  const Eigen::LLT<MatrixXd, Eigen::Lower> llt(without_points(normal, WV, damping));
  if (llt.info() != Eigen::Success) {
    return std::nullopt;
  }
  Step out;
  out.frames = llt.solve(normal.g - WV * normal.g_points);
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

/// Decrease of the cost that the undamped step promises.
double promised_decrease(const WindowNormal& normal) {
  const std::optional<Step> step = step_of(normal, 0.0);
  return step ? 0.5 * (normal.g.dot(step->frames) + normal.g_points.dot(step->points))
              : std::numeric_limits<double>::infinity();
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
    WindowState refitted = points_refitted(model, next, there);
    WindowNormal at_refitted = linearise(model, refitted);
    if (at_refitted.cost < there.cost) {
      next = std::move(refitted);
      there = std::move(at_refitted);
    }
    if (!(there.cost < normal.cost)) {
      damping *= 10.0;
      continue;
    }
    const bool done = damping <= kUndamped && normal.cost - there.cost < kPays;
    state = std::move(next);
    normal = std::move(there);
    damping = std::max(damping * 0.1, kDampingLeast);
    if (done) {
      break;
    }
  }
  normal.left = promised_decrease(normal);
  return normal;
}

MatrixXd frame_covariance(const WindowNormal& normal) {
  const MatrixXd WV = times_inverse(normal.W, normal.V, 0.0);
  const Eigen::LLT<MatrixXd, Eigen::Lower> llt(without_points(normal, WV, 0.0));
  if (llt.info() != Eigen::Success) {
    return {};
  }
  return llt.solve(MatrixXd::Identity(normal.A.rows(), normal.A.rows()));
}

}  // namespace limber::detail
