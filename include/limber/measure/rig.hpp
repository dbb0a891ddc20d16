// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>

#include "limber/core/pose.hpp"
#include "limber/sensors/calibration.hpp"

namespace limber {

/// One camera as the body carries it, and how its place depends on theta.
struct MountedCamera {
  Camera camera;
  Pose T_cam_body;
  /// With dtheta: T_cam_body becomes (Exp(J_rotation dtheta) R, p + J_translation dtheta). Zero where theta
  /// has no say.
  Eigen::Matrix<double, 3, 6> J_rotation = Eigen::Matrix<double, 3, 6>::Zero();
  Eigen::Matrix<double, 3, 6> J_translation = Eigen::Matrix<double, 3, 6>::Zero();
  bool depends_on_theta = false;
};

/// Both cameras, left first.
using MountedRig = std::array<MountedCamera, 2>;

/// @brief Places the cameras of an assumed calibration on the body.
/// Body = IMU or left camera: only cam1 depends on theta. Body = middle of the baseline: both do.
/// @note [Vivet2022], Eqs. (25)-(28) and the remark after Eq. (28).
[[nodiscard]] MountedRig mount(const StereoCalibration& calibration);

/// T_body_cam0 of the assumed calibration, whatever the body is.
[[nodiscard]] Pose body_from_cam0(const StereoCalibration& calibration);

}  // namespace limber
