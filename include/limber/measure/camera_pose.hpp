// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "limber/measure/rig.hpp"
#include "limber/state/state.hpp"

namespace limber {

/// Where a camera is when it takes an image, and how that depends on the state.
struct CameraPose {
  /// of the camera when it takes the image
  Pose T_world_cam;
  /// Rows: position (world), attitude (local, R_true = R Exp(dtheta)). Columns: a triplet of the error state.
  struct Block {
    /// first of three columns in the error state
    Eigen::Index col = 0;
    /// 6×3
    Eigen::Matrix<double, 6, kTriplet> value;
  };
  /// in no order; columns that are not named are zero
  std::vector<Block> blocks;
};

/// @brief The pose of cam0 in the image that is stamped with the time of T_world_body: pose, velocity and
/// rate of the body, mount and time offset of the camera, as far as they are in the state.
[[nodiscard]] CameraPose cam0_pose(const MountedCamera& cam0, const Pose& T_world_body,
                                   const StateLayout& layout);

}  // namespace limber
