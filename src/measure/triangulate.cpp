// SPDX-License-Identifier: MIT
#include "limber/measure/triangulate.hpp"

#include "limber/core/factors.hpp"
#include "limber/core/so3.hpp"

namespace limber {

using Eigen::Vector3d;

std::optional<double> inverse_depth_along(const Vector3d& d0, const Vector3d& d1, const Pose& T_cam1_cam0) {
  const Vector3d along = d1.cross(T_cam1_cam0.p);
  const double weight = along.squaredNorm();
  if (weight < 1e-12 * T_cam1_cam0.p.squaredNorm()) {
    return std::nullopt;
  }
  return -along.dot(d1.cross(T_cam1_cam0.R * d0)) / weight;
}

Eigen::Vector4d triangulate_dlt(const Vector3d& d0, const Vector3d& d1, const Pose& T_cam1_cam0) {
  Eigen::Matrix<double, 6, 4> A;
  A.topLeftCorner<3, 3>() = skew(d0);
  A.topRightCorner<3, 1>().setZero();
  A.bottomLeftCorner<3, 3>() = skew(d1) * T_cam1_cam0.R;
  A.bottomRightCorner<3, 1>() = d1.cross(T_cam1_cam0.p);
  const Eigen::Vector4d X = right_singular(A).V.col(3);
  return X(3) < 0.0 ? Eigen::Vector4d(-X) : X;
}

}  // namespace limber
