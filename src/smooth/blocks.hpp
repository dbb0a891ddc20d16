// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

#include "limber/state/state.hpp"

/// How states lie in the parameter blocks of the least-squares problem.
namespace limber::detail {

/// Position [m], then the quaternion of R_world_body (x, y, z, w).
using PoseBlock = std::array<double, 7>;
/// What the motion model adds in the order of StateLayout: velocity and biases, or velocity and rate.
using MotionBlock = std::array<double, 9>;

inline constexpr int kPoseBlock = 7;
inline constexpr int kPoseTangent = 6;

[[nodiscard]] inline int motion_size(MotionModel motion) {
  return static_cast<int>(StateLayout{motion}.body_size() - StateLayout::kPoseSize);
}

[[nodiscard]] inline Pose pose_of(const double* block) {
  return {Eigen::Map<const Eigen::Quaterniond>(block + 3).normalized().toRotationMatrix(),
          Eigen::Map<const Eigen::Vector3d>(block)};
}

inline void write_pose(const Pose& pose, double* block) {
  Eigen::Map<Eigen::Vector3d>{block} = pose.p;
  Eigen::Map<Eigen::Quaterniond> q(block + 3);
  q = Eigen::Quaterniond(pose.R);
}

/// @param motion_block  not read for odometry
[[nodiscard]] inline NavigationState state_of(MotionModel motion, const double* pose_block,
                                              const double* motion_block) {
  NavigationState out;
  out.T_world_body = pose_of(pose_block);
  if (motion == MotionModel::kOdometry) {
    return out;
  }
  using Map = Eigen::Map<const Eigen::Vector3d>;
  out.v_world_body = Map(motion_block);
  if (motion == MotionModel::kImu) {
    out.bias_gyro = Map(motion_block + 3);
    out.bias_accel = Map(motion_block + 6);
  } else {
    out.omega_body = Map(motion_block + 3);
  }
  return out;
}

[[nodiscard]] inline MotionBlock motion_block_of(MotionModel motion, const NavigationState& state) {
  MotionBlock out{};
  using Map = Eigen::Map<Eigen::Vector3d>;
  Map(out.data()) = state.v_world_body;
  Map(out.data() + 3) = motion == MotionModel::kImu ? state.bias_gyro : state.omega_body;
  Map(out.data() + 6) = state.bias_accel;
  return out;
}

}  // namespace limber::detail
