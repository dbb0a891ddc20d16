// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "diagnose/clustered_regression.hpp"
#include "diagnose/gyro_attitude.hpp"
#include "diagnose/left_turn.hpp"

/// @file
/// Turns of a recording by the camera and by the gyro, and the regressions that compare them.
namespace limber::detail {

/// A turn by the camera, and by the gyro at the present tau.
struct Compared {
  Eigen::Vector3d camera, gyro;   ///< mean rates [rad/s]
  Eigen::Vector3d slope, around;  ///< of the gyro: over the turn; a while before and behind it [rad/s^2]
  std::int64_t bin;               ///< fifth of a second of the recording
};

/// The turns that the gyro saw whole.
[[nodiscard]] std::vector<Compared> compare(const std::vector<Turn>& turns, const GyroAttitude& gyro,
                                            double tau);

/// What unknowns of one's own add to the camera's rate, by the gyro's.
using Columns = std::function<Eigen::Matrix3Xd(const Eigen::Vector3d& gyro)>;

/// Bins from which on the bias of the gyro is another.
using BiasSteps = std::vector<std::int64_t>;

/// Turns that overlap, and the tracks that they see, share a cluster, which is a second.
[[nodiscard]] std::int64_t cluster_of(const Compared& turn);

/// Rows for (bias, its steps, a change of tau, unknowns of one's own). The instrument of the gyro's slope is
/// its slope over a while before and behind: noise of the samples between is in both sides, and alone looks
/// like milliseconds.
[[nodiscard]] ClusteredRows rows_of(const std::vector<Compared>& compared, const BiasSteps& steps,
                                    const Columns& more);

/// A bias that steps would look like a mount that is turned, where the body turns otherwise behind the step.
[[nodiscard]] BiasSteps bias_steps(const std::vector<Compared>& compared);

}  // namespace limber::detail
