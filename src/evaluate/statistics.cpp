// SPDX-License-Identifier: MIT
#include "limber/evaluate/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace limber {
namespace {

constexpr double kTail = 0.025;  // on either side of an interval

}  // namespace

Statistics statistics_of(std::span<const double> values) {
  if (values.empty()) {
    throw std::invalid_argument("statistics: there are no values");
  }
  std::vector<double> sorted(values.begin(), values.end());
  if (!std::all_of(sorted.begin(), sorted.end(), [](double v) { return std::isfinite(v); })) {
    throw std::invalid_argument("statistics: a value is not finite");
  }
  std::sort(sorted.begin(), sorted.end());

  Statistics s;
  s.count = sorted.size();
  const auto n = static_cast<double>(s.count);
  double sum = 0.0;
  for (double v : sorted) {
    sum += v;
    s.sse += v * v;
  }
  s.mean = sum / n;
  s.rmse = std::sqrt(s.sse / n);
  double deviation = 0.0;
  for (double v : sorted) {
    deviation += (v - s.mean) * (v - s.mean);
  }
  s.std = std::sqrt(deviation / n);
  s.min = sorted.front();
  s.max = sorted.back();
  s.median = 0.5 * (sorted[(s.count - 1) / 2] + sorted[s.count / 2]);
  return s;
}

std::optional<MedianInterval> median_interval(std::span<const double> values) {
  std::vector<double> sorted(values.begin(), values.end());
  if (std::any_of(sorted.begin(), sorted.end(), [](double v) { return std::isnan(v); })) {
    throw std::invalid_argument("statistics: a value is not a number");
  }
  std::sort(sorted.begin(), sorted.end());
  if (sorted.empty()) {
    return std::nullopt;
  }
  const std::size_t n = sorted.size();
  const double low = sorted[(n - 1) / 2], high = sorted[n / 2];
  MedianInterval out{std::isinf(high) ? high : 0.5 * (low + high), {}, {}};
  // Probability that exactly k of n values lie below the median, and that at most so many do.
  double exactly = std::pow(0.5, static_cast<double>(n)), at_most = exactly;
  for (std::size_t k = 0; at_most <= kTail; ++k) {
    out.lower = sorted[k];
    out.upper = sorted[n - 1 - k];
    exactly *= static_cast<double>(n - k) / static_cast<double>(k + 1);
    at_most += exactly;
  }
  return out;
}

}  // namespace limber
