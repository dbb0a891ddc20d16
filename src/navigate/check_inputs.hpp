// SPDX-License-Identifier: MIT
#pragma once

#include "limber/health/input_alarm.hpp"
#include "limber/navigate/navigator_options.hpp"
#include "limber/sensors/samples.hpp"
#include "limber/state/initial_state.hpp"

/// What a filter refuses, with a message that says what was expected.
namespace limber::detail {

/// Further ahead of the state than this a frame or a sample is of another clock [s].
inline constexpr double kLongestJump = 3600.0;
/// Largest steps that a contradiction opens, of biases per axis.
inline constexpr StepSize kLargestStep = {0.2, 2.0, 0.15};

/// @throws std::invalid_argument for a noise that is negative or not finite, and the like
void check_options(const NavigatorOptions& options);
/// @throws std::invalid_argument for a mean or covariance that is not finite, an attitude that is no rotation
/// matrix, a covariance that is not symmetric or not positive semidefinite
void check_initial(const InitialState& initial);

/// @param previous_ns  of the frame before
/// @throws std::invalid_argument for a frame that is older than the state, not later than the one before, or
/// hours ahead; points as check_points; an id that comes twice
void check_frame(const StereoFrame& frame, std::int64_t state_ns, std::int64_t previous_ns);

}  // namespace limber::detail
