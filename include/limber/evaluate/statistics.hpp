// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>

namespace limber {

/// What is said of a list of errors, in the unit of the errors. The same seven numbers as the tool evo.
struct Statistics {
  double rmse = 0.0;
  double mean = 0.0;
  double median = 0.0;  ///< of an even count: the mean of the middle two
  double std = 0.0;     ///< about the mean, divided by the count
  double min = 0.0;
  double max = 0.0;
  double sse = 0.0;  ///< sum of squares [unit²]
  std::size_t count = 0;
};

/// @throws std::invalid_argument if there are no values, or one is not finite
[[nodiscard]] Statistics statistics_of(std::span<const double> values);

}  // namespace limber
