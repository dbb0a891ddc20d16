// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <vector>

#include "limber/sensors/samples.hpp"
#include "limber/sensors/true_rig.hpp"

namespace limber {

/// How the body moved. EuRoC's files have 8 columns (pose), 11 (with velocity) or 17 (with biases).
struct GroundTruth {
  /// body in world, strictly increasing time
  std::vector<GroundTruthState> states;
  /// false: velocities are zero
  bool has_velocity = false;
  /// false: biases are zero
  bool has_biases = false;
};

/// What is known of a recording that no sensor measured: for evaluation, `--init groundtruth` and `oracle`.
/// What is not known is empty.
struct RecordingTruth {
  /// of the body
  GroundTruth motion;
  /// track_id -> p_world_landmark [m]
  std::map<std::int64_t, Eigen::Vector3d> landmarks;
  /// theta(t), strictly increasing time
  std::vector<TrueRig> rig;
};

}  // namespace limber
