// SPDX-License-Identifier: MIT
#include "limber/evaluate/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace limber {

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

}  // namespace limber
