// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace limber {

/// Time from one stamp to another [s].
[[nodiscard]] inline double seconds_between(std::int64_t from_ns, std::int64_t to_ns) {
  return 1e-9 * static_cast<double>(to_ns - from_ns);
}

}  // namespace limber
