// SPDX-License-Identifier: MIT
#include "limber/measure/stereo_model.hpp"

#include <algorithm>

#include "limber/core/so3.hpp"

namespace limber {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Inverse depth below which a point is as good as infinitely far [1/m].
constexpr double kFarInverseDepth = 1e-6;

/// An inverse-depth landmark in the body frame of its anchor, times its inverse depth.
Vector3d scaled_in_anchor(const Landmark& landmark, const Anchor& anchor) {
  const Vector3d direction = landmark.R_cam0_chart * Vector3d(landmark.value.x(), landmark.value.y(), 1.0);
  return anchor.T_body_cam0.R * direction + landmark.value.z() * anchor.T_body_cam0.p;
}

BodyPoint cartesian_point(const Pose& T_world_body, const Landmark& landmark) {
  BodyPoint out;
  const Matrix3d R_body_world = T_world_body.R.transpose();
  out.Y = R_body_world * (landmark.value - T_world_body.p);
  out.w = 1.0;
  out.J_Y_position = -R_body_world;
  out.J_Y_attitude = skew(out.Y);
  out.J_Y_landmark = R_body_world;
  out.J_w_landmark.setZero();
  return out;
}

BodyPoint inverse_depth_point(const Pose& T_world_body, const Landmark& landmark, const Anchor& anchor) {
  BodyPoint out;
  const Matrix3d R_body_world = T_world_body.R.transpose();
  const Matrix3d R_body_anchor = R_body_world * anchor.T_world_body.R;
  const Vector3d Y_anchor = scaled_in_anchor(landmark, anchor);
  const Vector3d between = anchor.T_world_body.p - T_world_body.p;
  const double rho = landmark.value.z();
  out.Y = R_body_anchor * Y_anchor + rho * (R_body_world * between);
  out.w = rho;
  out.J_Y_position = -rho * R_body_world;
  out.J_Y_attitude = skew(out.Y);
  out.J_Y_anchor_position = rho * R_body_world;
  out.J_Y_anchor_attitude = -R_body_anchor * skew(Y_anchor);
  const Matrix3d chart = R_body_anchor * anchor.T_body_cam0.R * landmark.R_cam0_chart;
  out.J_Y_landmark.leftCols<2>() = chart.leftCols<2>();
  out.J_Y_landmark.col(2) = R_body_anchor * anchor.T_body_cam0.p + R_body_world * between;
  out.J_w_landmark << 0.0, 0.0, 1.0;
  return out;
}

/// Derivative with respect to all parameters beyond theta.
/// @param RY, X  the point, turned into the camera; and in it
/// @param J      of the pixel with respect to X
Eigen::Matrix<double, 2, kMoreParameters> jacobian_of_more(const MountedCamera& mounted,
                                                           const BodyPoint& point, const Vector3d& RY,
                                                           const Vector3d& X,
                                                           const Eigen::Matrix<double, 2, 3>& J,
                                                           const PointProjection& projection) {
  Eigen::Matrix<double, 2, kMoreParameters> out = Eigen::Matrix<double, 2, kMoreParameters>::Zero();
  const Eigen::Index own = first_of(mounted.own) - kBlockSize;
  out.middleCols<5>(own) = intrinsics_jacobian(mounted.camera, X, projection.uv);
  out.col(own + 5) =
      projection.J_position * mounted.motion.v_world + projection.J_attitude * mounted.motion.omega_body;
  out.rightCols<kBlockSize>() =
      J * (point.w * mounted.J_translation_mount - skew(RY) * mounted.J_rotation_mount);
  return out;
}

}  // namespace

BodyPoint body_point(const Pose& T_world_body, const Landmark& landmark, const Anchor* anchor) {
  return landmark.kind == LandmarkKind::kCartesian ? cartesian_point(T_world_body, landmark)
                                                   : inverse_depth_point(T_world_body, landmark, *anchor);
}

Vector3d world_position(const Landmark& landmark, const Anchor* anchor) {
  if (landmark.kind == LandmarkKind::kCartesian) {
    return landmark.value;
  }
  const double rho = std::max(landmark.value.z(), kFarInverseDepth);
  Landmark clamped = landmark;
  clamped.value.z() = rho;
  return anchor->T_world_body * Vector3d(scaled_in_anchor(clamped, *anchor) / rho);
}

BodyPoint body_point_at_exposure(const MountedCamera& mounted, const Pose& T_world_body,
                                 const Landmark& landmark, const Anchor* anchor) {
  BodyPoint out = body_point(at_exposure(mounted, T_world_body), landmark, anchor);
  if (mounted.time_offset_s != 0.0) {
    // R Exp(dtheta) Exp(omega dt) = R Exp(omega dt) Exp(Exp(−omega dt) dtheta).
    out.J_Y_attitude *= so3_exp(-mounted.time_offset_s * mounted.motion.omega_body);
  }
  return out;
}

std::optional<PointProjection> project_point(const MountedCamera& mounted, const BodyPoint& point) {
  const Matrix3d& R = mounted.T_cam_body.R;
  const Vector3d RY = R * point.Y;
  const Vector3d X = RY + point.w * mounted.T_cam_body.p;
  const std::optional<Projection> projection = project(mounted.camera, X);
  if (!projection) {
    return std::nullopt;
  }
  const Eigen::Matrix<double, 2, 3>& J = projection->J_uv_X;
  const Eigen::Matrix<double, 2, 3> JR = J * R;
  PointProjection out;
  out.uv = projection->uv;
  out.J_position = JR * point.J_Y_position;
  out.J_attitude = JR * point.J_Y_attitude;
  out.J_landmark = JR * point.J_Y_landmark + (J * mounted.T_cam_body.p) * point.J_w_landmark;
  out.J_anchor_position = JR * point.J_Y_anchor_position;
  out.J_anchor_attitude = JR * point.J_Y_anchor_attitude;
  if (mounted.depends_on_theta) {
    out.J_theta = J * (point.w * mounted.J_translation - skew(RY) * mounted.J_rotation);
  } else {
    out.J_theta.setZero();
  }
  if (mounted.with_parameters) {
    out.J_more = jacobian_of_more(mounted, point, RY, X, J, out);
  }
  if (mounted.time_offset_s != 0.0) {
    out.J_motion = {mounted.time_offset_s * out.J_position,
                    mounted.time_offset_s * out.J_attitude *
                        so3_right_jacobian(-mounted.time_offset_s * mounted.motion.omega_body)};
  }
  return out;
}

}  // namespace limber
