// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

#include "limber/run/run_options.hpp"

/// @file
/// What of the rig a method takes for exact.
namespace limber {

/// Whether a run's method takes an axis for exact: `ekf` all six, `lcekf` what it does not constrain; none
/// that is estimated or softened.
/// @param axis  of ax, ay, az, tx, ty, tz
[[nodiscard]] bool trusts_axis(const RunOptions& options, MotionModel motion, std::size_t axis);

/// No axis is trusted, and the baseline's length is: `lcekf` that constrains turn and direction alone, as it
/// does of vision alone unless it is told otherwise, and `adaptive` of vision alone.
[[nodiscard]] bool trusts_length_alone(const RunOptions& options, MotionModel motion);

/// @brief Whether a run's method takes the length of the baseline for exact, by either of both.
/// @param theta  assumed
[[nodiscard]] bool trusts_length(const RunOptions& options, MotionModel motion, const RigParameters& theta);

}  // namespace limber
