// SPDX-License-Identifier: MIT
#include "limber/sensors/calibration.hpp"

#include "limber/core/so3.hpp"

namespace limber {

Pose pose_from_rig(const RigParameters& theta) {
  return {rotation_from_euler_zyx(theta.head<3>()), theta.tail<3>()};
}

RigParameters rig_from_pose(const Pose& T_cam1_cam0) {
  RigParameters theta;
  theta << euler_zyx_from_rotation(T_cam1_cam0.R), T_cam1_cam0.p;
  return theta;
}

}  // namespace limber
