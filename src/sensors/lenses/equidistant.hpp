// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

#include "sensors/lenses/planar.hpp"

namespace limber::detail {

struct EquidistantRadius {
  double value;       ///< theta_d
  double derivative;  ///< d theta_d / d theta
};

inline EquidistantRadius equidistant_radius(const Equidistant& d, double theta) {
  const double s = theta * theta;
  return {theta * (1.0 + s * (d.k1 + s * (d.k2 + s * (d.k3 + s * d.k4)))),
          1.0 + s * (3.0 * d.k1 + s * (5.0 * d.k2 + s * (7.0 * d.k3 + s * 9.0 * d.k4)))};
}

/// Whether theta_d grows all the way from the axis to theta: beyond a fold, pixels belong to other rays.
inline bool is_monotonic(const Equidistant& d, double theta) {
  for (int k = 1; k <= kMonotonicSamples; ++k) {
    if (equidistant_radius(d, theta * k / kMonotonicSamples).derivative <= 0.0) {
      return false;
    }
  }
  return true;
}

template <>
struct Lens<Equidistant> {
  static constexpr std::string_view kName = "equidistant";
  static constexpr std::array<Coefficient<Equidistant>, 4> kCoefficients{{{"k1", &Equidistant::k1},
                                                                          {"k2", &Equidistant::k2},
                                                                          {"k3", &Equidistant::k3},
                                                                          {"k4", &Equidistant::k4}}};

  static std::optional<Projection> project(const Camera& camera, const Equidistant& d,
                                           const Eigen::Vector3d& X) {
    const double rho = X.head<2>().norm();
    const double range2 = X.squaredNorm();
    if (!X.allFinite() || range2 == 0.0 || (rho == 0.0 && X.z() <= 0.0)) {
      return std::nullopt;
    }
    const double theta = std::atan2(rho, X.z());
    if (!is_monotonic(d, theta)) {
      return std::nullopt;
    }
    const EquidistantRadius radius = equidistant_radius(d, theta);
    // m = theta_d (x, y) / rho; on the axis the limit is (x, y) / z.
    const bool on_axis = rho < 1e-9 * X.z();
    const double scale = on_axis ? 1.0 / X.z() : radius.value / rho;
    Eigen::Matrix<double, 2, 3> J = Eigen::Matrix<double, 2, 3>::Zero();
    J(0, 0) = J(1, 1) = scale;
    if (!on_axis) {
      const Eigen::Vector2d e = X.head<2>() / rho;
      const double dtheta_drho = X.z() / range2;
      const double dtheta_dz = -rho / range2;
      J.leftCols<2>() += e * e.transpose() * (radius.derivative * dtheta_drho - scale);
      J.col(2) = e * (radius.derivative * dtheta_dz);
    }
    Projection out;
    out.uv << camera.fu * scale * X.x() + camera.cu, camera.fv * scale * X.y() + camera.cv;
    out.J_uv_X = Eigen::Vector2d(camera.fu, camera.fv).asDiagonal() * J;
    return out;
  }

  static std::optional<Eigen::Vector3d> unproject(const Equidistant& d, const Eigen::Vector2d& target) {
    const double radius = target.norm();
    double theta = radius;
    for (int i = 0; i < kMaxIterations; ++i) {
      const EquidistantRadius r = equidistant_radius(d, theta);
      if (r.derivative <= 0.0) {
        theta *= 0.5;
        continue;
      }
      const double step = (radius - r.value) / r.derivative;
      theta += step;
      if (std::abs(step) < kConvergence * (1.0 + theta)) {
        if (theta < 0.0 || theta >= M_PI || !is_monotonic(d, theta)) {
          return std::nullopt;
        }
        const Eigen::Vector2d e =
            radius > 0.0 ? Eigen::Vector2d(target / radius) : Eigen::Vector2d(Eigen::Vector2d::Zero());
        return Eigen::Vector3d(std::sin(theta) * e.x(), std::sin(theta) * e.y(), std::cos(theta));
      }
    }
    return std::nullopt;
  }

  /// of theta + k1 theta^3 along (x, y) / rho
  static Eigen::Vector2d radial(const Equidistant& /*d*/, const Eigen::Vector3d& X) {
    const double rho = X.head<2>().norm(), theta = std::atan2(rho, X.z());
    return rho > 0.0 ? Eigen::Vector2d(X.head<2>() * (theta * theta * theta / rho))
                     : Eigen::Vector2d(Eigen::Vector2d::Zero());
  }
};

}  // namespace limber::detail
