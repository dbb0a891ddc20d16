// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "limber/health/tolerance.hpp"

namespace limber {

/// @brief "NAME=OK[:WRONG],...": by effect (px [px], depth [%]), where depth holds (baselines), or by axis
/// (ax, ay, az [deg], tx, ty, tz [mm]). What is not named keeps its default. WRONG defaults to twice OK, of
/// px to 10/3 of it.
/// @throws std::invalid_argument for anything else
[[nodiscard]] Tolerance parse_tolerance(const std::string& text);

}  // namespace limber
