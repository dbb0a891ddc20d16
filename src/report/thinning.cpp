// SPDX-License-Identifier: MIT
#include "limber/report/thinning.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace limber {
namespace {

std::vector<std::size_t> all_of(std::size_t count) {
  std::vector<std::size_t> indices(count);
  std::iota(indices.begin(), indices.end(), std::size_t{0});
  return indices;
}

/// Appends the lowest, the highest and the first missing sample of [begin, end), in order.
void append_extremes(std::span<const double> y, std::size_t begin, std::size_t end,
                     std::vector<std::size_t>& out) {
  std::array<std::size_t, 3> found = {end, end, end};
  auto& [lowest, highest, gap] = found;
  for (std::size_t k = begin; k < end; ++k) {
    if (std::isnan(y[k])) {
      gap = gap == end ? k : gap;
      continue;
    }
    lowest = lowest == end || y[k] < y[lowest] ? k : lowest;
    highest = highest == end || y[k] > y[highest] ? k : highest;
  }
  std::sort(found.begin(), found.end());
  for (const std::size_t k : found) {
    if (k != end && k != out.back()) {
      out.push_back(k);
    }
  }
}

}  // namespace

std::vector<std::size_t> thin_to_extremes(std::span<const double> y, std::size_t limit) {
  if (limit < 8) {
    throw std::invalid_argument("thin_to_extremes: the limit is below 8");
  }
  if (y.size() <= limit) {
    return all_of(y.size());
  }
  const std::size_t stretches = (limit - 2) / 3;  // each gives up to three: lowest, highest, a gap
  const std::size_t inner = y.size() - 2;
  std::vector<std::size_t> out = {0};
  for (std::size_t k = 0; k < stretches; ++k) {
    append_extremes(y, 1 + k * inner / stretches, 1 + (k + 1) * inner / stretches, out);
  }
  out.push_back(y.size() - 1);
  return out;
}

std::vector<std::size_t> thin_evenly(std::size_t count, std::size_t limit) {
  if (limit < 2) {
    throw std::invalid_argument("thin_evenly: the limit is below 2");
  }
  if (count <= limit) {
    return all_of(count);
  }
  std::vector<std::size_t> out(limit);
  for (std::size_t k = 0; k < limit; ++k) {
    out[k] = k * (count - 1) / (limit - 1);
  }
  return out;
}

}  // namespace limber
