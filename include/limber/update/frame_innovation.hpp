// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "limber/update/innovation.hpp"

namespace limber {

/// What the prior says about a frame's points, formed once for the gate and for the update.
struct FrameInnovation {
  Innovation innovation;           ///< of the turned measurement: all of its fourth rows are there
  std::vector<RowGroup> groups;    ///< where the rows of each group of the measurement are
  Eigen::MatrixXd seen_by_fourth;  ///< as in TurnedMeasurement
  Eigen::MatrixXd by_pose;         ///< m×6: how the first six states, the pose, move the innovation's rows
};

/// @brief Turns the measurement, then forms the innovation.
/// @throws std::invalid_argument as check
[[nodiscard]] FrameInnovation form_frame_innovation(const Covariance& P,
                                                    const LinearMeasurement& measurement);

/// @brief The rows that the update needs: the same update, the same NIS.
///
/// There are as many fourth rows as points, while what they look at has few dimensions (the epipolar geometry
/// five): an orthogonal change of these rows leaves as many, and the rest is noise alone.
/// @param kept  one flag per group; the rows of the others are left out
/// @note [MourikisRoumeliotis2007], section III-E.
[[nodiscard]] Innovation compressed(FrameInnovation frame, const std::vector<bool>& kept);

/// The same of all groups.
[[nodiscard]] Innovation compressed(FrameInnovation frame);

}  // namespace limber
