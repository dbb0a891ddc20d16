// SPDX-License-Identifier: MIT
#pragma once

#include "window_problem.hpp"

namespace limber::detail {

/// What the pixels and the points' own weak prior add to the normal equations.
void add_points(const WindowModel& model, const WindowState& state, WindowNormal& out);

}  // namespace limber::detail
