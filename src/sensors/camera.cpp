// SPDX-License-Identifier: MIT
#include "limber/sensors/camera.hpp"

#include <variant>

#include "sensors/lenses/all_lenses.hpp"

namespace limber {

using detail::LensOf;
using Eigen::Vector2d;
using Eigen::Vector3d;

std::optional<Projection> project(const Camera& camera, const Vector3d& X) {
  return std::visit([&](const auto& d) { return LensOf<decltype(d)>::project(camera, d, X); },
                    camera.distortion);
}

Eigen::Matrix<double, 2, 5> intrinsics_jacobian(const Camera& camera, const Vector3d& X, const Vector2d& uv) {
  const Vector2d radial =
      std::visit([&](const auto& d) { return LensOf<decltype(d)>::radial(d, X); }, camera.distortion);
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
  return std::visit([&](const auto& d) { return LensOf<decltype(d)>::unproject(d, target); },
                    camera.distortion);
}

bool in_image(const Camera& camera, const Vector2d& uv, double border) {
  return uv.x() >= border && uv.y() >= border && uv.x() < camera.width - border &&
         uv.y() < camera.height - border;
}

}  // namespace limber
