// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>

namespace limber {

/// @brief How an input (a rate, a specific force, a velocity) has moved in the last tens of seconds: the
/// bound on what could have happened where no sample tells.
///
/// The input is taken for a stationary process with the variance and the rate of change that were seen; its
/// correlation over a time tau then is 1 - min((rate tau)^2, 2 variance) / (2 variance). All figures are
/// those of the axis that moved most. A prior stands in for the first second.
class MotionSeen {
 public:
  /// @param spread  prior standard deviation per axis [unit]
  /// @param rate    prior rate of change per axis [unit/s]
  MotionSeen(double spread, double rate);

  /// One value more, later than those before.
  /// @param value  per axis [unit]
  void add(std::int64_t t_ns, const Eigen::Vector3d& value);

  /// All values were taken that much later [ns].
  void shift(std::int64_t by_ns);

  [[nodiscard]] double spread() const;  ///< about the mean [unit]
  [[nodiscard]] double rms() const;     ///< about zero [unit]
  [[nodiscard]] double rate() const;    ///< rms change per second, seen over some 50 ms [unit/s]

  /// Correlation with the value `tau` seconds away, in [0, 1], if the input spreads by `spread`.
  [[nodiscard]] double correlation(double tau, double spread) const;

 private:
  // Sums with weights in seconds that fade over kMemory.
  double weight_, rate_weight_;
  Eigen::Vector3d sum_ = Eigen::Vector3d::Zero(), squares_, rate_squares_;
  Eigen::Vector3d reference_ = Eigen::Vector3d::Zero();  // a value some 50 ms ago
  std::int64_t last_ns_ = std::numeric_limits<std::int64_t>::min(), reference_ns_ = 0;
};

}  // namespace limber
