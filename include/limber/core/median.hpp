// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace limber {

/// The value of rank k, the smallest having rank 0. @param k  below the number of values
template <typename T>
[[nodiscard]] T order_statistic(std::vector<T> values, std::size_t k) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(k);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// The value that the given share of the others lies below, by the nearest rank: 0 is the smallest, 1 the
/// largest. @param values  not empty
[[nodiscard]] inline double quantile(std::vector<double> values, double share) {
  const double rank = share * static_cast<double>(values.size() - 1);
  return order_statistic(std::move(values), static_cast<std::size_t>(std::lround(rank)));
}

/// The middle value; of an even count the larger of the two in the middle, which is a value that occurred:
/// for thresholds and scales. @param values  not empty
template <typename T>
[[nodiscard]] T upper_median(std::vector<T> values) {
  const std::size_t middle = values.size() / 2;
  return order_statistic(std::move(values), middle);
}

/// Standard deviation of normal numbers of mean zero, from the median of their magnitudes, which no share of
/// wild ones below a half can move far. @param magnitudes  not empty
[[nodiscard]] inline double sigma_of_magnitudes(std::vector<double> magnitudes) {
  constexpr double kSigmaOverMedian = 1.4826;
  return kSigmaOverMedian * upper_median(std::move(magnitudes));
}

/// The middle value; of an even count the mean of the two in the middle (the larger one if that is infinite):
/// for what is shown. @param values  not empty
[[nodiscard]] inline double median(std::vector<double> values) {
  const double low = order_statistic(values, (values.size() - 1) / 2), high = upper_median(std::move(values));
  return std::isinf(high) ? high : 0.5 * (low + high);
}

}  // namespace limber
