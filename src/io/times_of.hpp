// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

namespace limber::detail {

/// When samples, frames or states were taken [ns], in their order.
[[nodiscard]] std::vector<std::int64_t> times_of(const auto& samples) {
  std::vector<std::int64_t> out;
  out.reserve(samples.size());
  for (const auto& sample : samples) {
    out.push_back(sample.t_ns);
  }
  return out;
}

}  // namespace limber::detail
