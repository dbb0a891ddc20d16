// SPDX-License-Identifier: MIT
#include "limber/measure/camera_pose.hpp"

#include "limber/core/so3.hpp"

namespace limber {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using L = StateLayout;

namespace {

constexpr std::size_t kOfCam0 = 0, kOfMount = 2;  // in StateLayout::has_more
constexpr Eigen::Index kTimeOffsetColumn = 5;     // in the block of a camera

}  // namespace

CameraPose cam0_pose(const MountedCamera& cam0, const Pose& T_world_body, const StateLayout& layout) {
  const Pose T_world_exposed = at_exposure(cam0, T_world_body);
  const Pose T_body_cam = cam0.T_cam_body.inverse();
  const Matrix3d& R = T_world_exposed.R;
  const double dt = cam0.time_offset_s;
  const Matrix3d lever = -R * skew(T_body_cam.p);  // of a small turn of the exposed body
  const Matrix3d turn = T_body_cam.R.transpose();

  CameraPose out;
  out.T_world_cam = T_world_exposed * T_body_cam;
  const auto add = [&](Eigen::Index col, const Matrix3d& of_position, const Matrix3d& of_attitude) {
    CameraPose::Block& block = out.blocks.emplace_back();
    block.col = col;
    block.value << of_position, of_attitude;
  };
  const Matrix3d since_stamp = so3_exp(-dt * cam0.motion.omega_body);
  add(L::kPosition, Matrix3d::Identity(), Matrix3d::Zero());
  add(L::kAttitude, lever * since_stamp, turn * since_stamp);
  if (dt != 0.0 && layout.motion != MotionModel::kOdometry) {
    const bool imu = layout.motion == MotionModel::kImu;
    const Matrix3d of_rate = (imu ? -dt : dt) * so3_right_jacobian(dt * cam0.motion.omega_body);
    add(L::kVelocity, dt * Matrix3d::Identity(), Matrix3d::Zero());
    add(imu ? L::kBiasGyro : L::kRate, lever * of_rate, turn * of_rate);
  }
  if (layout.has_more[kOfMount]) {
    const Eigen::Index at = layout.more(kOfMount);
    add(at, Matrix3d::Zero(), turn);
    add(at + kTriplet, R, Matrix3d::Zero());
  }
  if (layout.has_more[kOfCam0]) {
    const Vector3d& omega = cam0.motion.omega_body;
    Matrix3d of_position = Matrix3d::Zero(), of_attitude = Matrix3d::Zero();
    constexpr Eigen::Index kColumn = kTimeOffsetColumn - kTriplet;
    of_position.col(kColumn) = cam0.motion.v_world + lever * omega;
    of_attitude.col(kColumn) = turn * omega;
    add(layout.more(kOfCam0) + kTriplet, of_position, of_attitude);
  }
  return out;
}

}  // namespace limber
