// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/LU>
#include <optional>

#include "sensors/lenses/lens.hpp"

/// Lenses that distort the plane z = 1.
namespace limber::detail {

inline constexpr int kMaxIterations = 30;
inline constexpr double kConvergence = 1e-13;  // of normalised coordinates
inline constexpr int kMonotonicSamples = 16;   // between the axis and a ray

struct Distorted {
  Eigen::Vector2d m;  ///< distorted normalised coordinates
  Eigen::Matrix2d J;  ///< derivative with respect to the undistorted ones
};

/// Newton's method on distort(m) = target; `distort` gives nothing beyond its valid disc. The bearing of m,
/// or nothing, is what `bearing` makes of it.
template <typename Distort, typename Bearing>
std::optional<Eigen::Vector3d> undistort(const Distort& distort, const Eigen::Vector2d& target,
                                         const Bearing& bearing) {
  Eigen::Vector2d m = target;
  for (int i = 0; i < kMaxIterations; ++i) {
    const std::optional<Distorted> distorted = distort(m);
    if (!distorted) {
      // Outside the valid disc: come back towards the axis.
      m *= 0.5;
      continue;
    }
    const Eigen::Vector2d step = distorted->J.inverse() * (target - distorted->m);
    m += step;
    if (!m.allFinite()) {
      return std::nullopt;
    }
    if (step.norm() < kConvergence * (1.0 + m.norm()) && distort(m)) {
      return bearing(m);
    }
  }
  return std::nullopt;
}

/// project and unproject by Lens<Model>::distort of m = (x/z, y/z).
template <typename Model>
struct PlanarLens {
  static std::optional<Projection> project(const Camera& camera, const Model& d, const Eigen::Vector3d& X) {
    if (!(X.z() > 0.0) || !X.allFinite()) {
      return std::nullopt;
    }
    const Eigen::Vector2d m = X.head<2>() / X.z();
    const std::optional<Distorted> distorted = Lens<Model>::distort(d, m);
    if (!distorted) {
      return std::nullopt;
    }
    Eigen::Matrix<double, 2, 3> J_m_X;
    J_m_X << 1.0, 0.0, -m.x(), 0.0, 1.0, -m.y();
    J_m_X /= X.z();
    Projection out;
    out.uv << camera.fu * distorted->m.x() + camera.cu, camera.fv * distorted->m.y() + camera.cv;
    out.J_uv_X = Eigen::Vector2d(camera.fu, camera.fv).asDiagonal() * distorted->J * J_m_X;
    return out;
  }

  static std::optional<Eigen::Vector3d> unproject(const Model& d, const Eigen::Vector2d& target) {
    return undistort([&](const Eigen::Vector2d& m) { return Lens<Model>::distort(d, m); }, target,
                     [](const Eigen::Vector2d& m) {
                       return std::optional<Eigen::Vector3d>(Eigen::Vector3d(m.x(), m.y(), 1.0).normalized());
                     });
  }

  /// of m + k1 m |m|^2
  static Eigen::Vector2d radial(const Model& /*d*/, const Eigen::Vector3d& X) {
    const Eigen::Vector2d m = X.head<2>() / X.z();
    return m * m.squaredNorm();
  }
};

}  // namespace limber::detail
