// SPDX-License-Identifier: MIT
#include "rig_files/foreign_cameras.hpp"

#include <cmath>

namespace limber::detail {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Vector2d to_pixel(const Pinhole& pinhole, const Vector2d& m) {
  return {pinhole.fu * m.x() + pinhole.cu, pinhole.fv * m.y() + pinhole.cv};
}

Vector2d opencv_distort(const Vector2d& m, const std::array<double, 12>& k) {
  const double x = m.x(), y = m.y(), s = m.squaredNorm();
  const double radial =
      (1.0 + s * (k[0] + s * (k[1] + s * k[4]))) / (1.0 + s * (k[5] + s * (k[6] + s * k[7])));
  return {x * radial + 2.0 * k[2] * x * y + k[3] * (s + 2.0 * x * x) + s * (k[8] + s * k[9]),
          y * radial + k[2] * (s + 2.0 * y * y) + 2.0 * k[3] * x * y + s * (k[10] + s * k[11])};
}

}  // namespace

ForeignProjection double_sphere(const Pinhole& pinhole, double xi, double alpha) {
  return [=](const Vector3d& X) -> std::optional<Vector2d> {
    const double d1 = X.norm(), shifted = xi * d1 + X.z();
    const double d2 = std::sqrt(X.head<2>().squaredNorm() + shifted * shifted);
    const double denominator = alpha * d2 + (1.0 - alpha) * shifted;
    if (!(denominator > 0.0)) {
      return std::nullopt;
    }
    return to_pixel(pinhole, X.head<2>() / denominator);
  };
}

ForeignProjection extended_unified(const Pinhole& pinhole, double alpha, double beta) {
  return [=](const Vector3d& X) -> std::optional<Vector2d> {
    const double d = std::sqrt(beta * X.head<2>().squaredNorm() + X.z() * X.z());
    const double denominator = alpha * d + (1.0 - alpha) * X.z();
    if (!(denominator > 0.0)) {
      return std::nullopt;
    }
    return to_pixel(pinhole, X.head<2>() / denominator);
  };
}

ForeignProjection opencv_pinhole(const Pinhole& pinhole, const std::array<double, 12>& distortion) {
  return [=](const Vector3d& X) -> std::optional<Vector2d> {
    if (!(X.z() > 0.0)) {
      return std::nullopt;
    }
    return to_pixel(pinhole, opencv_distort(X.head<2>() / X.z(), distortion));
  };
}

}  // namespace limber::detail
