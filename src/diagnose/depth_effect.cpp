// SPDX-License-Identifier: MIT
#include "limber/diagnose/depth_effect.hpp"

#include <cmath>

#include "limber/measure/triangulate.hpp"

namespace limber {
namespace {

constexpr double kStep = 1e-6;  // of the numerical derivative [rad, m]

double variance(const RigParameters& assumed, const RigOffset& offset, double depth) {
  double sum = 0.0;
  for (Eigen::Index k = 0; k < 6; ++k) {
    const RigParameters step = kStep * RigParameters::Unit(k);
    const auto above = depth_error(assumed, offset.delta + step, depth);
    const auto below = depth_error(assumed, offset.delta - step, depth);
    if (above && below) {
      const double slope = (*above - *below) / (2.0 * kStep);
      sum += slope * slope * offset.sigma(k) * offset.sigma(k);
    }
  }
  return sum;
}

}  // namespace

std::optional<double> depth_error(const RigParameters& assumed, const RigParameters& delta, double depth) {
  const Eigen::Vector3d ahead = Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d seen = pose_from_rig(assumed + delta) * Eigen::Vector3d(depth * ahead);
  const std::optional<double> rho = inverse_depth_along(ahead, seen.normalized(), pose_from_rig(assumed));
  return rho && *rho > 0.0 ? std::optional(1.0 / *rho - depth) : std::nullopt;
}

std::vector<DepthEffect> depth_effects(const RigParameters& assumed, const RigOffset& offset) {
  std::vector<DepthEffect> out;
  for (const double depth : kShownDepths) {
    out.push_back(
        {depth, depth_error(assumed, offset.delta, depth), std::sqrt(variance(assumed, offset, depth))});
  }
  return out;
}

}  // namespace limber
