// SPDX-License-Identifier: MIT
#pragma once

#include "sensors/lenses/radial_tangential.hpp"

namespace limber::detail {

/// 1 + s (k1 + s (k2 + s k3)) and its derivative with respect to s.
struct Cubic {
  double value, slope;
};

inline Cubic cubic(double k1, double k2, double k3, double s) {
  return {1.0 + s * (k1 + s * (k2 + s * k3)), k1 + s * (2.0 * k2 + s * 3.0 * k3)};
}

template <>
struct Lens<Rational> : PlanarLens<Rational> {
  static constexpr std::string_view kName = "rational-polynomial";
  static constexpr std::array<Coefficient<Rational>, 8> kCoefficients{{{"k1", &Rational::k1},
                                                                       {"k2", &Rational::k2},
                                                                       {"p1", &Rational::p1},
                                                                       {"p2", &Rational::p2},
                                                                       {"k3", &Rational::k3},
                                                                       {"k4", &Rational::k4},
                                                                       {"k5", &Rational::k5},
                                                                       {"k6", &Rational::k6}}};

  /// Whether r n/d grows all the way from the axis to r: beyond a fold or a pole, pixels belong to other
  /// rays.
  static bool is_monotonic(const Rational& k, double r2) {
    bool grows = true;
    for (int i = 1; i <= kMonotonicSamples; ++i) {  // without a way out: becomes vector instructions
      const double share = static_cast<double>(i) / kMonotonicSamples, s = r2 * share * share;
      const Cubic n = cubic(k.k1, k.k2, k.k3, s), d = cubic(k.k4, k.k5, k.k6, s);
      grows &= (d.value > 0.0) & ((n.value + 2.0 * s * n.slope) * d.value > 2.0 * s * n.value * d.slope);
    }
    return grows;
  }

  static std::optional<Distorted> distort(const Rational& k, const Eigen::Vector2d& m) {
    const double r2 = m.squaredNorm();
    if (!is_monotonic(k, r2)) {
      return std::nullopt;
    }
    const Cubic n = cubic(k.k1, k.k2, k.k3, r2), d = cubic(k.k4, k.k5, k.k6, r2);
    const double radial = n.value / d.value;
    return radial_tangential(k, m, radial, (n.slope - radial * d.slope) / d.value);
  }

  static Eigen::Vector2d radial(const Rational& k, const Eigen::Vector3d& X) {
    const Eigen::Vector2d m = X.head<2>() / X.z();
    const double r2 = m.squaredNorm();
    return m * (r2 / cubic(k.k4, k.k5, k.k6, r2).value);
  }
};

}  // namespace limber::detail
