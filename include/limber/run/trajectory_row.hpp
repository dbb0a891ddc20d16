// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "limber/datasets/trajectory_files.hpp"
#include "limber/predict/motion.hpp"

namespace limber {

/// A state as a row of a trajectory; biases where an IMU drives the prediction.
/// @param pose_covariance  of position and attitude, as in TrajectoryRow
/// @param motion_covariance  of what the motion model adds, in the order of StateLayout (IMU 9×9, constant
/// velocity 6×6); empty where it is not known, and with odometry
[[nodiscard]] inline TrajectoryRow trajectory_row(const NavigationState& nav, MotionModel motion,
                                                  const Eigen::Matrix<double, 6, 6>& pose_covariance,
                                                  const Eigen::MatrixXd& motion_covariance = {}) {
  TrajectoryRow row;
  row.t_ns = nav.t_ns;
  row.T_world_body = nav.T_world_body;
  row.v_world_body = nav.v_world_body;
  if (motion == MotionModel::kImu) {
    row.bias_gyro = nav.bias_gyro;
    row.bias_accel = nav.bias_accel;
  }
  row.covariance = pose_covariance;
  if (motion_covariance.size() > 0) {
    const Eigen::VectorXd sigma = motion_covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
    row.sigma_v = sigma.head<3>();
    if (motion == MotionModel::kImu) {
      row.sigma_bias_gyro = sigma.segment<3>(3);
      row.sigma_bias_accel = sigma.segment<3>(6);
    }
  }
  return row;
}

}  // namespace limber
