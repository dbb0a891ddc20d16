// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "sensors/lenses/planar.hpp"

namespace limber::detail {

/// Smallest positive root of 1 + b s + c s^2, or infinity.
inline double smallest_positive_root(double b, double c) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  if (c == 0.0) {
    return b < 0.0 ? -1.0 / b : kNone;
  }
  const double discriminant = b * b - 4.0 * c;
  if (discriminant < 0.0) {
    return kNone;
  }
  const double root = std::sqrt(discriminant);
  const double low = std::min((-b - root) / (2.0 * c), (-b + root) / (2.0 * c));
  const double high = std::max((-b - root) / (2.0 * c), (-b + root) / (2.0 * c));
  return low > 0.0 ? low : (high > 0.0 ? high : kNone);
}

/// What a radial factor and the tangential terms make of m.
/// @param slope  derivative of `radial` with respect to |m|^2
template <typename Model>
Distorted radial_tangential(const Model& d, const Eigen::Vector2d& m, double radial, double slope) {
  const double x = m.x(), y = m.y();
  const double r2 = m.squaredNorm();
  const double dradial = 2.0 * slope;
  Distorted out;
  out.m << x * radial + 2.0 * d.p1 * x * y + d.p2 * (r2 + 2.0 * x * x),
      y * radial + d.p1 * (r2 + 2.0 * y * y) + 2.0 * d.p2 * x * y;
  const double cross = x * y * dradial + 2.0 * d.p1 * x + 2.0 * d.p2 * y;
  out.J << radial + x * x * dradial + 2.0 * d.p1 * y + 6.0 * d.p2 * x, cross, cross,
      radial + y * y * dradial + 6.0 * d.p1 * y + 2.0 * d.p2 * x;
  return out;
}

template <>
struct Lens<RadialTangential> : PlanarLens<RadialTangential> {
  static constexpr std::string_view kName = "radial-tangential";
  static constexpr std::array<Coefficient<RadialTangential>, 4> kCoefficients{
      {{"k1", &RadialTangential::k1},
       {"k2", &RadialTangential::k2},
       {"p1", &RadialTangential::p1},
       {"p2", &RadialTangential::p2}}};

  static std::optional<Distorted> distort(const RadialTangential& d, const Eigen::Vector2d& m) {
    const double r2 = m.squaredNorm();
    // r (1 + k1 r^2 + k2 r^4) must still grow at r: 1 + 3 k1 r^2 + 5 k2 r^4 > 0 on the way there.
    if (r2 >= smallest_positive_root(3.0 * d.k1, 5.0 * d.k2)) {
      return std::nullopt;
    }
    return radial_tangential(d, m, 1.0 + r2 * (d.k1 + r2 * d.k2), d.k1 + 2.0 * r2 * d.k2);
  }
};

}  // namespace limber::detail
