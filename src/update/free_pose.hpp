// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "judge.hpp"
#include "limber/update/gate.hpp"
#include "limber/update/innovation.hpp"

/// What any pose, or any pose and any rig, could explain of groups that fail: see gate().
namespace limber::detail {

/// What is judged, where the pose may be off by anything.
[[nodiscard]] Judged with_free_pose(const Judged& judged, const Innovation& innovation);

/// What is judged, where the pose and all parameters may be off by anything.
/// @param by_pose  PredictedPose::by_pose
[[nodiscard]] Judged with_free_everything(const Judged& judged, const Innovation& innovation,
                                          const Eigen::MatrixXd& by_pose);

/// The accepted groups and the others cannot be of one rigid world: what is free puts not both where they
/// are.
[[nodiscard]] bool are_two_bodies(const Judged& judged, const GateReport& report,
                                  const GateThresholds& thresholds);

/// Hardly a group is near where any pose and any parameters could put most of them together.
/// @param free  with_free_everything
[[nodiscard]] bool are_mismatched(const Judged& free, const GateThresholds& thresholds);

}  // namespace limber::detail
