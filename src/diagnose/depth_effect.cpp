// SPDX-License-Identifier: MIT
#include "limber/diagnose/depth_effect.hpp"

#include <algorithm>
#include <cmath>

#include "limber/measure/triangulate.hpp"

namespace limber {
namespace {

constexpr double kStep = 1e-6;  // of the numerical derivative [rad, m]

/// Without what it says along the baseline that is assumed.
RigEstimate without_length(const RigParameters& assumed, RigEstimate offset) {
  RigParameters along = RigParameters::Zero();
  along.tail<3>() = assumed.tail<3>().normalized();
  const Eigen::Matrix<double, 6, 6> rest =
      Eigen::Matrix<double, 6, 6>::Identity() - along * along.transpose();
  offset.delta = rest * offset.delta;
  offset.covariance = rest * offset.covariance * rest;
  return offset;
}

double variance(const RigParameters& assumed, const RigEstimate& offset, double depth) {
  RigParameters slope = RigParameters::Zero();
  for (Eigen::Index k = 0; k < 6; ++k) {
    const RigParameters step = kStep * RigParameters::Unit(k);
    const auto above = depth_error(assumed, offset.delta + step, depth);
    const auto below = depth_error(assumed, offset.delta - step, depth);
    if (above && below) {
      slope(k) = (*above - *below) / (2.0 * kStep);
    }
  }
  return std::max(slope.dot(offset.covariance * slope), 0.0);
}

}  // namespace

std::optional<double> depth_error(const RigParameters& assumed, const RigParameters& delta, double depth) {
  const Eigen::Vector3d ahead = Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d seen = pose_from_rig(assumed + delta) * Eigen::Vector3d(depth * ahead);
  const std::optional<double> rho = inverse_depth_along(ahead, seen.normalized(), pose_from_rig(assumed));
  return rho && *rho > 0.0 ? std::optional(1.0 / *rho - depth) : std::nullopt;
}

std::vector<DepthEffect> depth_effects(const RigParameters& assumed, const RigEstimate& offset, bool metric) {
  const RigEstimate seen = metric ? offset : without_length(assumed, offset);
  std::vector<DepthEffect> out;
  for (const double depth : kShownDepths) {
    out.push_back(
        {depth, depth_error(assumed, seen.delta, depth), std::sqrt(variance(assumed, seen, depth))});
  }
  return out;
}

}  // namespace limber
