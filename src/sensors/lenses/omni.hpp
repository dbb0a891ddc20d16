// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

#include "sensors/lenses/radial_tangential.hpp"

namespace limber::detail {

/// [Mei2007] The point on the unit sphere, seen from xi behind its centre, then radial-tangential distortion.
template <>
struct Lens<Omni> {
  static constexpr std::string_view kName = "omni";
  static constexpr std::array<Coefficient<Omni>, 5> kCoefficients{
      {{"xi", &Omni::xi}, {"k1", &Omni::k1}, {"k2", &Omni::k2}, {"p1", &Omni::p1}, {"p2", &Omni::p2}}};

  static RadialTangential plane(const Omni& d) { return {d.k1, d.k2, d.p1, d.p2}; }

  static std::optional<Projection> project(const Camera& camera, const Omni& d, const Eigen::Vector3d& X) {
    const double range = X.norm(), depth = X.z() + d.xi * range;
    // Beyond depth 0 nothing meets the plane; beyond range + xi z = 0 (xi > 1) the sphere hides itself.
    if (!X.allFinite() || !(depth > 0.0) || !(range + d.xi * X.z() > 0.0)) {
      return std::nullopt;
    }
    const Eigen::Vector2d n = X.head<2>() / depth;
    const auto distorted = Lens<RadialTangential>::distort(plane(d), n);
    if (!distorted) {
      return std::nullopt;
    }
    const Eigen::RowVector3d J_depth_X = Eigen::RowVector3d::UnitZ() + (d.xi / range) * X.transpose();
    Eigen::Matrix<double, 2, 3> J_n_X = Eigen::Matrix<double, 2, 3>::Identity() - n * J_depth_X;
    J_n_X /= depth;
    const Eigen::Vector2d f = (1.0 + d.xi) * Eigen::Vector2d(camera.fu, camera.fv);
    Projection out;
    out.uv << f.x() * distorted->m.x() + camera.cu, f.y() * distorted->m.y() + camera.cv;
    out.J_uv_X = f.asDiagonal() * distorted->J * J_n_X;
    return out;
  }

  static std::optional<Eigen::Vector3d> unproject(const Omni& d, const Eigen::Vector2d& target) {
    const RadialTangential lens = plane(d);
    return undistort([&](const Eigen::Vector2d& n) { return Lens<RadialTangential>::distort(lens, n); },
                     target / (1.0 + d.xi), [&](const Eigen::Vector2d& n) { return on_sphere(d.xi, n); });
  }

  /// |(eta n, eta - xi)| = 1, the nearer of two points.
  static std::optional<Eigen::Vector3d> on_sphere(double xi, const Eigen::Vector2d& n) {
    const double s = n.squaredNorm(), inside = 1.0 + (1.0 - xi * xi) * s;
    if (!(inside > 0.0)) {
      return std::nullopt;
    }
    const double eta = (xi + std::sqrt(inside)) / (1.0 + s);
    return Eigen::Vector3d(eta * n.x(), eta * n.y(), eta - xi);
  }

  static Eigen::Vector2d radial(const Omni& d, const Eigen::Vector3d& X) {
    const Eigen::Vector2d n = X.head<2>() / (X.z() + d.xi * X.norm());
    return (1.0 + d.xi) * n.squaredNorm() * n;
  }
};

}  // namespace limber::detail
