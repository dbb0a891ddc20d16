// SPDX-License-Identifier: MIT
#pragma once

#include "window_problem.hpp"

namespace limber::detail {

/// Half the sum of the pixels' squares, after the robust loss.
[[nodiscard]] double cost_of_pixels(const WindowModel& model, const WindowState& state);

/// Half of what the pixels' rows are worth if they are as noisy as assumed.
[[nodiscard]] double expected_cost(const WindowModel& model, const WindowState& state);

/// The model with pixels as good as they show themselves from frame to frame.
[[nodiscard]] WindowModel with_shown_pixels(WindowModel model, const WindowState& state);

/// What the pixels and the points' own weak prior add to the normal equations.
void add_points(const WindowModel& model, const WindowState& state, WindowNormal& out);

}  // namespace limber::detail
