// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace limber {

/// What is said of a list of errors, in the unit of the errors. The same seven numbers as the tool evo.
struct Statistics {
  /// root of the mean square
  double rmse = 0.0;
  /// of the values
  double mean = 0.0;
  double median = 0.0;  ///< of an even count: the mean of the middle two
  double std = 0.0;     ///< about the mean, divided by the count
  /// smallest value
  double min = 0.0;
  /// largest value
  double max = 0.0;
  double sse = 0.0;  ///< sum of squares [unit²]
  /// how many values
  std::size_t count = 0;
};

/// @throws std::invalid_argument if there are no values, or one is not finite
[[nodiscard]] Statistics statistics_of(std::span<const double> values);

/// The middle of a sample, and what may be said of the middle of what it was drawn from.
struct MedianInterval {
  double median = 0.0;  ///< of an even count: the mean of the middle two
  std::optional<double> lower,
      upper;  ///< hold the true median with 95 % at least; fewer than six values: none
};

/// @brief Median with an interval that holds whatever the distribution: two of the values in order, by the
/// binomial distribution of how many lie below the median. The extremes of six values hold it with 97 %.
/// @param values may hold infinity, for what has no number and is worse than all
/// @return nothing if there are no values
/// @throws std::invalid_argument if one is NaN
[[nodiscard]] std::optional<MedianInterval> median_interval(std::span<const double> values);

/// The mean of a sequence, and what may be said of the mean of what it was drawn from.
struct MeanInterval {
  /// of the values
  double mean = 0.0;
  std::optional<double> lower, upper;  ///< hold the true mean with 95 %; fewer than five values: none
  double correlation = 0.0;            ///< of neighbours, as it was allowed for [-]
  /// how many values
  std::size_t count = 0;
};

/// Fewer values give no interval of their mean.
inline constexpr std::size_t kFewestForMean = 5;

/// The x that Student's |T| exceeds with 5 %. @param dof  degrees of freedom, one or more
[[nodiscard]] double student_quantile(double dof);

/// @brief Mean with Student's interval. Neighbours may be alike: with r, the correlation of neighbours (its
/// bias 1/n added, 0 to 0.9), n values count as n (1 - r) / (1 + r), in the variance of the mean and in the
/// degrees of freedom, of which there is one at least. [ZwiersStorch1995]
/// @param values in the order in which they came
/// @return nothing if there are no values
/// @throws std::invalid_argument if one is not finite
[[nodiscard]] std::optional<MeanInterval> mean_interval(std::span<const double> values);

}  // namespace limber
