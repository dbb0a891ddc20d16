// SPDX-License-Identifier: MIT
#pragma once

#include "limber/datasets/trajectory_files.hpp"
#include "limber/predict/motion.hpp"

namespace limber {

/// A state as a row of a trajectory; biases where an IMU drives the prediction.
/// @param pose_covariance  of position and attitude, as in TrajectoryRow
[[nodiscard]] inline TrajectoryRow trajectory_row(const NavigationState& nav, MotionModel motion,
                                                  const Eigen::Matrix<double, 6, 6>& pose_covariance) {
  TrajectoryRow row;
  row.t_ns = nav.t_ns;
  row.T_world_body = nav.T_world_body;
  row.v_world_body = nav.v_world_body;
  if (motion == MotionModel::kImu) {
    row.bias_gyro = nav.bias_gyro;
    row.bias_accel = nav.bias_accel;
  }
  row.covariance = pose_covariance;
  return row;
}

}  // namespace limber
