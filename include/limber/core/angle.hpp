// SPDX-License-Identifier: MIT
#pragma once

#include <numbers>

namespace limber {

inline constexpr double kToDegrees = 180.0 / std::numbers::pi;  ///< of an angle in radians

}  // namespace limber
