// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace limber {

/// A stamp or a duration [s].
[[nodiscard]] constexpr double to_seconds(std::int64_t t_ns) { return 1e-9 * static_cast<double>(t_ns); }

/// Time from one stamp to another [s].
[[nodiscard]] constexpr double seconds_between(std::int64_t from_ns, std::int64_t to_ns) {
  return to_seconds(to_ns - from_ns);
}

}  // namespace limber
