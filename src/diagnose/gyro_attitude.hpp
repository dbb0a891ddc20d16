// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "limber/sensors/samples.hpp"

namespace limber::detail {

/// What the gyro says of the attitude, linear between samples.
class GyroAttitude {
 public:
  /// @param imu  at least two samples, in order of time; must outlive this
  explicit GyroAttitude(std::span<const ImuSample> imu);

  /// @brief Rate of the body at a time [s] since the first sample [rad/s]; nothing outside of the samples.
  [[nodiscard]] std::optional<Eigen::Vector3d> rate(double t_s) const;

  /// @brief R_first_body at a time [s] since the first sample; nothing outside of the samples.
  [[nodiscard]] std::optional<Eigen::Matrix3d> at(double t_s) const;

  /// @brief Mean rate between two times [s]: the rotation vector of R_begin_end over its time [rad/s].
  [[nodiscard]] std::optional<Eigen::Vector3d> mean_rate(double begin_s, double end_s) const;

  /// @brief Mean of the samples between two times, for rates that may be in any unit; nothing without any.
  [[nodiscard]] std::optional<Eigen::Vector3d> mean_samples(double begin_s, double end_s) const;

  /// Mean time between samples [s].
  [[nodiscard]] double sample_time() const;

 private:
  /// Index of the sample at or before a time, if there is one behind it, too.
  [[nodiscard]] std::optional<std::size_t> before(double t_s) const;

  std::span<const ImuSample> imu_;
  std::vector<double> times_;               // since the first sample [s]
  std::vector<Eigen::Matrix3d> attitudes_;  // R_first_k
};

}  // namespace limber::detail
