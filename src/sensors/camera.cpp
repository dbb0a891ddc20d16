// SPDX-License-Identifier: MIT
#include "limber/sensors/camera.hpp"

#include <Eigen/LU>

#include <cmath>
#include <limits>

namespace limber {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kMaxIterations = 30;
constexpr double kConvergence = 1e-13;  // of normalised coordinates
constexpr int kMonotonicSamples = 16;   // between the axis and a fisheye ray

struct Distorted {
  Vector2d m;  // distorted normalised coordinates
  Matrix2d J;  // derivative with respect to the undistorted ones
};

/// Smallest positive root of 1 + b s + c s^2, or infinity.
double smallest_positive_root(double b, double c) {
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

std::optional<Distorted> distort(const NoDistortion&, const Vector2d& m) {
  return Distorted{m, Matrix2d::Identity()};
}

std::optional<Distorted> distort(const RadialTangential& d, const Vector2d& m) {
  const double x = m.x(), y = m.y();
  const double r2 = m.squaredNorm();
  // r (1 + k1 r^2 + k2 r^4) must still grow at r: 1 + 3 k1 r^2 + 5 k2 r^4 > 0 on the way there.
  if (r2 >= smallest_positive_root(3.0 * d.k1, 5.0 * d.k2)) {
    return std::nullopt;
  }
  const double radial = 1.0 + r2 * (d.k1 + r2 * d.k2);
  const double dradial = 2.0 * (d.k1 + 2.0 * r2 * d.k2);  // d radial / d(r^2) * 2, times x or y
  Distorted out;
  out.m << x * radial + 2.0 * d.p1 * x * y + d.p2 * (r2 + 2.0 * x * x),
      y * radial + d.p1 * (r2 + 2.0 * y * y) + 2.0 * d.p2 * x * y;
  const double cross = x * y * dradial + 2.0 * d.p1 * x + 2.0 * d.p2 * y;
  out.J << radial + x * x * dradial + 2.0 * d.p1 * y + 6.0 * d.p2 * x, cross, cross,
      radial + y * y * dradial + 6.0 * d.p1 * y + 2.0 * d.p2 * x;
  return out;
}

struct EquidistantRadius {
  double value;       // theta_d
  double derivative;  // d theta_d / d theta
};

EquidistantRadius equidistant_radius(const Equidistant& d, double theta) {
  const double s = theta * theta;
  return {theta * (1.0 + s * (d.k1 + s * (d.k2 + s * (d.k3 + s * d.k4)))),
          1.0 + s * (3.0 * d.k1 + s * (5.0 * d.k2 + s * (7.0 * d.k3 + s * 9.0 * d.k4)))};
}

/// Whether theta_d grows all the way from the axis to theta: beyond a fold, pixels belong to other rays.
bool is_monotonic(const Equidistant& d, double theta) {
  for (int k = 1; k <= kMonotonicSamples; ++k) {
    if (equidistant_radius(d, theta * k / kMonotonicSamples).derivative <= 0.0) {
      return false;
    }
  }
  return true;
}

std::optional<Projection> project_equidistant(const Camera& camera, const Equidistant& d, const Vector3d& X) {
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
    const Vector2d e = X.head<2>() / rho;
    const double dtheta_drho = X.z() / range2;
    const double dtheta_dz = -rho / range2;
    J.leftCols<2>() += e * e.transpose() * (radius.derivative * dtheta_drho - scale);
    J.col(2) = e * (radius.derivative * dtheta_dz);
  }
  Projection out;
  out.uv << camera.fu * scale * X.x() + camera.cu, camera.fv * scale * X.y() + camera.cv;
  out.J_uv_X = Vector2d(camera.fu, camera.fv).asDiagonal() * J;
  return out;
}

template <typename PlanarDistortion>
std::optional<Projection> project_planar(const Camera& camera, const PlanarDistortion& d, const Vector3d& X) {
  if (!(X.z() > 0.0) || !X.allFinite()) {
    return std::nullopt;
  }
  const Vector2d m = X.head<2>() / X.z();
  const std::optional<Distorted> distorted = distort(d, m);
  if (!distorted) {
    return std::nullopt;
  }
  Eigen::Matrix<double, 2, 3> J_m_X;
  J_m_X << 1.0, 0.0, -m.x(), 0.0, 1.0, -m.y();
  J_m_X /= X.z();
  Projection out;
  out.uv << camera.fu * distorted->m.x() + camera.cu, camera.fv * distorted->m.y() + camera.cv;
  out.J_uv_X = Vector2d(camera.fu, camera.fv).asDiagonal() * distorted->J * J_m_X;
  return out;
}

/// Newton's method on distort(m) = target.
template <typename PlanarDistortion>
std::optional<Vector3d> unproject_planar(const PlanarDistortion& d, const Vector2d& target) {
  Vector2d m = target;
  for (int i = 0; i < kMaxIterations; ++i) {
    std::optional<Distorted> distorted = distort(d, m);
    if (!distorted) {
      // Outside the valid disc: come back towards the axis.
      m *= 0.5;
      continue;
    }
    const Vector2d step = distorted->J.inverse() * (target - distorted->m);
    m += step;
    if (!m.allFinite()) {
      return std::nullopt;
    }
    if (step.norm() < kConvergence * (1.0 + m.norm()) && distort(d, m)) {
      return Vector3d(m.x(), m.y(), 1.0).normalized();
    }
  }
  return std::nullopt;
}

std::optional<Vector3d> unproject_equidistant(const Equidistant& d, const Vector2d& target) {
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
      const Vector2d e = radius > 0.0 ? Vector2d(target / radius) : Vector2d::Zero();
      return Vector3d(std::sin(theta) * e.x(), std::sin(theta) * e.y(), std::cos(theta));
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<Projection> project(const Camera& camera, const Vector3d& X) {
  return std::visit(
      [&](const auto& d) -> std::optional<Projection> {
        if constexpr (std::is_same_v<std::decay_t<decltype(d)>, Equidistant>) {
          return project_equidistant(camera, d, X);
        } else {
          return project_planar(camera, d, X);
        }
      },
      camera.distortion);
}

Eigen::Matrix<double, 2, 5> intrinsics_jacobian(const Camera& camera, const Vector3d& X, const Vector2d& uv) {
  // m + k1 m |m|^2 (planar), theta_d = theta + k1 theta^3 along (x, y) / rho (fisheye).
  Vector2d radial;
  if (std::holds_alternative<Equidistant>(camera.distortion)) {
    const double rho = X.head<2>().norm(), theta = std::atan2(rho, X.z());
    radial = rho > 0.0 ? Vector2d(X.head<2>() * (theta * theta * theta / rho)) : Vector2d::Zero();
  } else {
    const Vector2d m = X.head<2>() / X.z();
    radial = m * m.squaredNorm();
  }
  Eigen::Matrix<double, 2, 5> J;
  J << (uv.x() - camera.cu) / camera.fu, 0.0, 1.0, 0.0, camera.fu * radial.x(),  //
      0.0, (uv.y() - camera.cv) / camera.fv, 0.0, 1.0, camera.fv * radial.y();
  return J;
}

std::optional<Vector3d> unproject(const Camera& camera, const Vector2d& uv) {
  const Vector2d target((uv.x() - camera.cu) / camera.fu, (uv.y() - camera.cv) / camera.fv);
  if (!target.allFinite()) {
    return std::nullopt;
  }
  return std::visit(
      [&](const auto& d) -> std::optional<Vector3d> {
        if constexpr (std::is_same_v<std::decay_t<decltype(d)>, Equidistant>) {
          return unproject_equidistant(d, target);
        } else {
          return unproject_planar(d, target);
        }
      },
      camera.distortion);
}

bool in_image(const Camera& camera, const Vector2d& uv, double border) {
  return uv.x() >= border && uv.y() >= border && uv.x() < camera.width - border &&
         uv.y() < camera.height - border;
}

}  // namespace limber
