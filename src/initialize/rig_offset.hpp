// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <limits>

#include "window_problem.hpp"

namespace limber::detail {

/// What a window in which theta was free in every frame says of a rig that stays as it is.
struct RigOffset {
  double p_value = 0.0;  ///< that the rig is the assumed one, if it stays as it is
  /// Mean square of what the frames' theta scatter about their mean, by their covariance: 1 of a rig that
  /// stays as it is.
  double scatter = std::numeric_limits<double>::infinity();
};

/// @param covariance  frame_covariance of the solution
/// @param noise       variance of its pixels over the assumed one
[[nodiscard]] RigOffset rig_offset(const WindowModel& model, const WindowState& solution,
                                   const Eigen::MatrixXd& covariance, double noise);

/// Whether nothing contradicts the rig: it may be trusted until it is proven wrong.
[[nodiscard]] bool looks_sound(const RigOffset& offset);

}  // namespace limber::detail
