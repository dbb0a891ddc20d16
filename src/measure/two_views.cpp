// SPDX-License-Identifier: MIT
#include "measure/two_views.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <utility>

#include "limber/core/factors.hpp"
#include "limber/core/median.hpp"
#include "limber/core/so3.hpp"
#include "limber/measure/epipolar.hpp"
#include "limber/measure/triangulate.hpp"

namespace limber::detail {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kFewestPoints = 10;
constexpr int kIterations = 20;
constexpr double kConverged = 1e-5;  // of rad and m
constexpr double kMost = 0.8;        // share of the points
constexpr double kPixel = 0.5;       // standard deviation of a pixel [px]
constexpr double kDisparity =
    50.0;  // of what stereo says of a point's depth [px]: an error of the rig must fit in
constexpr double kHuber = 2.0;  // standard deviations
constexpr double kParameterPrior = 0.05;

/// One point in both frames, z = 1.
struct Pair {
  Vector3d from;
  Vector2d to;
  double by_stereo = 0.0, inverse_depth = 0.0;                          ///< along `from` [1/m]
  Vector2d from_slope = Vector2d::Zero(), to_slope = Vector2d::Zero();  ///< see MovingPoint
};

std::vector<Pair> pairs_of(const StereoCalibration& calibration, const StereoFrame& from,
                           const StereoFrame& to) {
  const Pose T_cam1_cam0 = pose_from_rig(calibration.theta);
  std::unordered_map<std::int64_t, StereoBearings> first;
  for (const StereoObservation& o : from.observations) {
    if (const auto pair = bearings(calibration, o)) {
      first[o.track_id] = *pair;
    }
  }
  std::vector<Pair> out;
  for (const StereoObservation& o : to.observations) {
    const auto it = first.find(o.track_id);
    if (it == first.end() || !o.in_cam0) {
      continue;
    }
    const auto d = unproject(calibration.cam0, o.uv_cam0);
    const auto& [cam0, cam1] = it->second;
    const auto rho = inverse_depth_along(cam0, cam1.normalized(), T_cam1_cam0);
    if (d && d->z() > 0.0 && rho) {
      out.push_back({cam0, (*d / d->z()).head<2>(), *rho, *rho});
    }
  }
  return out;
}

using Vector7d = Eigen::Matrix<double, 7, 1>;
using Matrix7d = Eigen::Matrix<double, 7, 7>;

/// X_to = R X_from + t, in cam0, with places that a parameter moves.
struct Motion {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Vector3d t = Vector3d::Zero();
  double parameter = 0.0;  ///< see MovingPoint::slope
};

/// One point's part in a Gauss-Newton step of (R, t, parameter, its depth).
struct Linearized {
  Eigen::Matrix<double, 2, 7> J;
  Vector2d J_depth, residual;
};

std::optional<Linearized> linearize(const Motion& motion, const Pair& p) {
  Vector3d from = p.from, from_slope = Vector3d::Zero();
  from_slope.head<2>() = p.from_slope;
  from += motion.parameter * from_slope;
  const Vector3d X = motion.R * from + p.inverse_depth * motion.t;
  if (!(X.z() > 0.0)) {
    return std::nullopt;
  }
  Eigen::Matrix<double, 2, 3> D;
  D << 1.0 / X.z(), 0.0, -X.x() / (X.z() * X.z()), 0.0, 1.0 / X.z(), -X.y() / (X.z() * X.z());
  Linearized out;
  out.J << -D * motion.R * skew(from), p.inverse_depth * D, D * motion.R * from_slope - p.to_slope;
  out.J_depth = D * motion.t;
  out.residual = p.to + motion.parameter * p.to_slope - X.head<2>() / X.z();
  return out;
}

/// What is known beforehand, as standard deviations.
struct Known {
  double pixel, inverse_depth;
  double parameter = 1.0;
};

/// A Gauss-Newton step: its length, and the equations that it solved, without what is known of the
/// parameter.
struct Improved {
  double length = 0.0,
         squares = 0.0;  ///< squares of the residuals in standard deviations, with their weights
  Matrix7d A = Matrix7d::Zero();
};

/// Moves the motion and the depths by a Gauss-Newton step; nothing where it fails.
std::optional<Improved> improve(Motion& motion, std::vector<Pair>& pairs, const Known& known) {
  Improved out;
  Vector7d b = Vector7d::Zero();
  const double noise = 2.0 * known.pixel * known.pixel;
  const double prior = known.inverse_depth * known.inverse_depth;
  for (const Pair& p : pairs) {
    const auto part = linearize(motion, p);
    if (!part) {
      continue;
    }
    // The depth is eliminated: what it may be wrong by is noise along the epipolar line.
    const Vector2d residual = part->residual + part->J_depth * (p.inverse_depth - p.by_stereo);
    const Eigen::Matrix2d variance =
        noise * Eigen::Matrix2d::Identity() + prior * part->J_depth * part->J_depth.transpose();
    const Eigen::Matrix2d information = variance.inverse();
    const double size = std::sqrt(residual.dot(information * residual));
    const double weight = size <= kHuber ? 1.0 : kHuber / size;
    out.A += weight * part->J.transpose() * information * part->J;
    out.squares += weight * size * size;
    b += weight * part->J.transpose() * information * residual;
  }
  Matrix7d A = out.A;
  A(6, 6) += 1.0 / (known.parameter * known.parameter);
  b(6) -= motion.parameter / (known.parameter * known.parameter);
  const Vector7d step = solve_symmetric(A, b);
  if (!step.allFinite()) {
    return std::nullopt;
  }
  for (Pair& p : pairs) {
    if (const auto part = linearize(motion, p)) {
      const double along = part->J_depth.dot(part->residual - part->J * step);
      p.inverse_depth += (along / noise + (p.by_stereo - p.inverse_depth) / prior) /
                         (part->J_depth.squaredNorm() / noise + 1.0 / prior);
    }
  }
  motion.R = so3_normalized(motion.R * so3_exp(step.head<3>()));
  motion.t += step.segment<3>(3);
  motion.parameter += step(6);
  out.length = step.norm();
  return out;
}

/// Steps until they are short. @return the last one; nothing where it fails
std::optional<Improved> converge(Motion& motion, std::vector<Pair>& pairs, const Known& known) {
  for (int i = 0; i < kIterations; ++i) {
    auto step = improve(motion, pairs, known);
    if (!step || step->length < kConverged) {
      return step;
    }
  }
  return std::nullopt;
}

double most_distances(const Motion& motion, const std::vector<Pair>& pairs) {
  std::vector<double> distances;
  for (const Pair& p : pairs) {
    const auto part = linearize(motion, p);
    distances.push_back(part ? part->residual.norm() : std::numeric_limits<double>::infinity());
  }
  const auto rank = static_cast<std::size_t>(kMost * static_cast<double>(distances.size()));
  return order_statistic(std::move(distances), rank);
}

/// See TwoViews; infinite where a turn cannot be told from a shift.
double confusion(const Improved& last, const Known& known, std::size_t points) {
  const Eigen::Matrix<double, 6, 6> A = last.A.topLeftCorner<6, 6>();
  const double variance = 0.5 * A.inverse().topLeftCorner<2, 2>().trace();
  const double alone = 2.0 * known.pixel * known.pixel / static_cast<double>(points);
  return variance > 0.0 ? std::sqrt(variance / alone) : std::numeric_limits<double>::infinity();
}

}  // namespace

std::optional<TwoViews> left_motion(const StereoCalibration& calibration, const StereoFrame& from,
                                    const StereoFrame& to) {
  std::vector<Pair> pairs = pairs_of(calibration, from, to);
  if (pairs.size() < kFewestPoints) {
    return std::nullopt;
  }
  const double focal = calibration.cam0.fu;
  const Known known{kPixel / focal, kDisparity / (focal * calibration.theta.tail<3>().norm())};
  Motion motion;
  const auto last = converge(motion, pairs, known);
  if (!last) {
    return std::nullopt;
  }
  return TwoViews{calibration.T_body_cam0.R * so3_log(motion.R.transpose()),
                  focal * most_distances(motion, pairs), confusion(*last, known, pairs.size())};
}

std::optional<ParameterFit> parameter_between(const MovingPoints& from, const MovingPoints& to,
                                              double focal_px, double baseline) {
  std::vector<Pair> pairs;
  for (const auto& [id, point] : to) {
    const auto first = from.find(id);
    if (first != from.end() && first->second.inverse_depth) {
      const MovingPoint& was = first->second;
      pairs.push_back({was.place.homogeneous(), point.place, *was.inverse_depth, *was.inverse_depth,
                       was.slope, point.slope});
    }
  }
  if (pairs.size() < kFewestPoints) {
    return std::nullopt;
  }
  const Known known{kPixel / focal_px, kDisparity / (focal_px * baseline), kParameterPrior};
  Motion motion;
  const auto last = converge(motion, pairs, known);
  if (!last) {
    return std::nullopt;
  }
  const Eigen::Matrix<double, 6, 6> others = last->A.topLeftCorner<6, 6>();
  const Eigen::Matrix<double, 6, 1> with = last->A.topRightCorner<6, 1>();
  const double information = last->A(6, 6) - with.dot(solve_symmetric(others, with));
  const double gradient = motion.parameter * (information + 1.0 / (kParameterPrior * kParameterPrior));
  return ParameterFit{information, gradient, last->squares, pairs.size()};
}

}  // namespace limber::detail
