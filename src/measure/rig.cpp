// SPDX-License-Identifier: MIT
#include "limber/measure/rig.hpp"

#include "limber/core/so3.hpp"

namespace limber {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// T_cam0_body for the body in the middle of the baseline: R_cam0_body = Exp(−phi/2), phi = Log(R_s), and
/// half of the way to cam1, whose centre stands at c = −R_sᵀ t_s. Jacobians in the sense of MountedCamera.
MountedCamera middle_seen_from_cam0(const RigParameters& theta) {
  const Pose T_cam1_cam0 = pose_from_rig(theta);
  const Matrix3d& R_s = T_cam1_cam0.R;
  const Vector3d phi = so3_log(R_s);
  MountedCamera out;
  out.T_cam_body.R = so3_exp(-0.5 * phi);
  out.T_cam_body.p = -0.5 * (R_s.transpose() * T_cam1_cam0.p);
  out.depends_on_theta = true;

  const Matrix3d axes = euler_zyx_axes(theta.head<3>());  // dR_s = skew(axes da) R_s
  // phi + dphi with Exp(phi + dphi) = Exp(axes da) Exp(phi) = Exp(phi) Exp(R_sᵀ axes da).
  const Matrix3d J_phi = so3_right_jacobian_inverse(phi) * R_s.transpose() * axes;
  // Exp(−(phi + dphi)/2) = Exp(−phi/2 − dphi/2) = Exp(Jl(−phi/2)(−dphi/2)) Exp(−phi/2), Jl(x) = Jr(−x).
  out.J_rotation.leftCols<3>() = -0.5 * so3_right_jacobian(0.5 * phi) * J_phi;
  // d(R_sᵀ t) = R_sᵀ skew(t) axes da + R_sᵀ dt.
  out.J_translation.leftCols<3>() = -0.5 * R_s.transpose() * skew(T_cam1_cam0.p) * axes;
  out.J_translation.rightCols<3>() = -0.5 * R_s.transpose();
  return out;
}

/// cam1 from cam0: T_cam1_body = T_cam1_cam0(theta) T_cam0_body(theta).
MountedCamera chain_cam1(const RigParameters& theta, const MountedCamera& cam0) {
  const Pose T_cam1_cam0 = pose_from_rig(theta);
  const Matrix3d axes = euler_zyx_axes(theta.head<3>());
  MountedCamera out;
  out.T_cam_body = T_cam1_cam0 * cam0.T_cam_body;
  out.depends_on_theta = true;
  out.J_rotation = T_cam1_cam0.R * cam0.J_rotation;
  out.J_rotation.leftCols<3>() += axes;
  out.J_translation = T_cam1_cam0.R * cam0.J_translation;
  out.J_translation.leftCols<3>() -= skew(T_cam1_cam0.R * cam0.T_cam_body.p) * axes;
  out.J_translation.rightCols<3>() += Matrix3d::Identity();
  return out;
}

/// T_body_cam0 := (Exp(phi) R, p + d), and so T_cam0_body := (Exp(−R_cb phi) R_cb, ...).
void set_mount_jacobians(MountedCamera& cam0, MountedCamera& cam1, const Matrix3d& R_cam1_cam0) {
  const Matrix3d& R_cam0_body = cam0.T_cam_body.R;
  cam0.J_rotation_mount.leftCols<3>() = -R_cam0_body;
  cam0.J_translation_mount << skew(cam0.T_cam_body.p) * R_cam0_body, -R_cam0_body;
  cam1.J_rotation_mount = R_cam1_cam0 * cam0.J_rotation_mount;
  cam1.J_translation_mount = R_cam1_cam0 * cam0.J_translation_mount;
}

}  // namespace

Pose body_from_cam0(const StereoCalibration& calibration) {
  switch (calibration.body) {
    case BodyFrame::kImu:
      return calibration.T_body_cam0;
    case BodyFrame::kMiddleOfBaseline:
      return middle_seen_from_cam0(calibration.theta).T_cam_body.inverse();
    case BodyFrame::kCam0:
      break;
  }
  return {};
}

Pose body_from_cam0(const StereoCalibration& calibration, const TrueRig& truth) {
  StereoCalibration as_built = calibration;
  as_built.theta = truth.theta;
  return body_from_cam0(as_built);
}

MountedRig mount(const StereoCalibration& calibration) {
  MountedCamera cam0;
  if (calibration.body == BodyFrame::kMiddleOfBaseline) {
    cam0 = middle_seen_from_cam0(calibration.theta);
  } else {
    cam0.T_cam_body = body_from_cam0(calibration).inverse();
  }
  MountedCamera cam1 = chain_cam1(calibration.theta, cam0);
  if (calibration.body == BodyFrame::kImu) {
    set_mount_jacobians(cam0, cam1, pose_from_rig(calibration.theta).R);
  }
  cam1.own = ParameterBlock::kCam1;
  cam0.camera = calibration.cam0;
  cam1.camera = calibration.cam1;
  cam0.time_offset_s = calibration.time_offset_s[0];
  cam1.time_offset_s = calibration.time_offset_s[1];
  return {cam0, cam1};
}

Pose at_exposure(const MountedCamera& mounted, const Pose& T_world_body) {
  if (mounted.time_offset_s == 0.0) {
    return T_world_body;
  }
  return {T_world_body.R * so3_exp(mounted.time_offset_s * mounted.motion.omega_body),
          T_world_body.p + mounted.time_offset_s * mounted.motion.v_world};
}

}  // namespace limber
