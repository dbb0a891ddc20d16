// SPDX-License-Identifier: MIT
#include "limber/measure/epipolar.hpp"

#include "limber/core/so3.hpp"

namespace limber::detail {

using Eigen::Vector3d;

PoseSlope epipolar_slope(const StereoBearings& pair, const Pose& T_cam1_cam0) {
  const Vector3d turned = T_cam1_cam0.R * pair.cam0, line = T_cam1_cam0.p.cross(turned);
  const double length = std::hypot(line.x(), line.y());
  const Vector3d normal = line / length;
  // error = line . cam1 / length, line = p x R d: by the line first.
  const Vector3d by_line =
      (pair.cam1 - normal.dot(pair.cam1) * Vector3d(normal.x(), normal.y(), 0.0)) / length;
  PoseSlope out;
  out << turned.cross(by_line.cross(T_cam1_cam0.p)).transpose(), turned.cross(by_line).transpose();
  return out;
}

Eigen::Matrix<double, 6, 6> pose_by_theta(const RigParameters& theta) {
  Eigen::Matrix<double, 6, 6> out = Eigen::Matrix<double, 6, 6>::Identity();
  out.topLeftCorner<3, 3>() = euler_zyx_axes(theta.head<3>());
  return out;
}

}  // namespace limber::detail
