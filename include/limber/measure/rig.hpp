// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>

#include "limber/core/pose.hpp"
#include "limber/sensors/calibration.hpp"
#include "limber/sensors/parameters.hpp"
#include "limber/sensors/true_rig.hpp"

namespace limber {

/// How the body moves.
struct BodyMotion {
  Eigen::Vector3d v_world = Eigen::Vector3d::Zero();     ///< [m/s]
  Eigen::Vector3d omega_body = Eigen::Vector3d::Zero();  ///< [rad/s]
};

/// One camera as the body carries it, and how its place depends on theta.
struct MountedCamera {
  ParameterBlock own = ParameterBlock::kCam0;  ///< which parameters are those of this camera alone
  /// intrinsics and distortion, as assumed
  Camera camera;
  /// of the body at the stamp of an image
  Pose T_cam_body;
  /// With dtheta: T_cam_body becomes (Exp(J_rotation dtheta) R, p + J_translation dtheta). Zero where theta
  /// has no say.
  Eigen::Matrix<double, 3, 6> J_rotation = Eigen::Matrix<double, 3, 6>::Zero();
  /// [m per rad, m per m]
  Eigen::Matrix<double, 3, 6> J_translation = Eigen::Matrix<double, 3, 6>::Zero();
  /// whether theta moves it against the body
  bool depends_on_theta = false;
  /// The same for an error of the mount (limber/sensors/parameters.hpp).
  Eigen::Matrix<double, 3, 6> J_rotation_mount = Eigen::Matrix<double, 3, 6>::Zero();
  /// of the translation, as J_translation
  Eigen::Matrix<double, 3, 6> J_translation_mount = Eigen::Matrix<double, 3, 6>::Zero();
  double time_offset_s = 0.0;    ///< its images are that much later than their stamps
  BodyMotion motion;             ///< at the stamp; needed for time offsets alone
  bool with_parameters = false;  ///< derivatives with respect to all parameters are wanted, not theta alone
};

/// Both cameras, left first.
using MountedRig = std::array<MountedCamera, 2>;

/// How many parameters the rig's cameras are differentiated by: those of theta, or all.
[[nodiscard]] inline Eigen::Index jacobian_width(const MountedRig& rig) {
  return rig[0].with_parameters ? kParameters : kBlockSize;
}

/// @brief Places the cameras of an assumed calibration on the body.
/// Body = IMU or left camera: only cam1 depends on theta. Body = middle of the baseline: both do.
/// @note [Vivet2022], Eqs. (25)-(28) and the remark after Eq. (28).
[[nodiscard]] MountedRig mount(const StereoCalibration& calibration);

/// Where the body is when a camera takes the image that is stamped with the time of T_world_body.
[[nodiscard]] Pose at_exposure(const MountedCamera& mounted, const Pose& T_world_body);

/// T_body_cam0 of the assumed calibration, whatever the body is.
[[nodiscard]] Pose body_from_cam0(const StereoCalibration& calibration);
/// The true one, of a rig with that calibration but for theta; for simulators.
[[nodiscard]] Pose body_from_cam0(const StereoCalibration& calibration, const TrueRig& truth);

}  // namespace limber
