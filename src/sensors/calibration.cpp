// SPDX-License-Identifier: MIT
#include "limber/sensors/calibration.hpp"

#include <cmath>

#include "limber/core/so3.hpp"

namespace limber {

namespace {

constexpr double kPlausibleAngle = 0.1 * M_PI / 180.0;  // [rad]
constexpr double kPlausibleShare = 0.05;                // of the baseline

}  // namespace

Pose pose_from_rig(const RigParameters& theta) {
  return {rotation_from_euler_zyx(theta.head<3>()), theta.tail<3>()};
}

RigParameters rig_from_pose(const Pose& T_cam1_cam0) {
  RigParameters theta;
  theta << euler_zyx_from_rotation(T_cam1_cam0.R), T_cam1_cam0.p;
  return theta;
}

double StereoCalibration::baseline() const { return theta.tail<3>().norm(); }

RigParameters plausible_error(double baseline) {
  RigParameters out;
  out << Eigen::Vector3d::Constant(kPlausibleAngle), Eigen::Vector3d::Constant(kPlausibleShare * baseline);
  return out;
}

}  // namespace limber
