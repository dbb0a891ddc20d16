// SPDX-License-Identifier: MIT
#include "diagnose/gyro_attitude.hpp"

#include <algorithm>
#include <iterator>

#include "limber/core/so3.hpp"
#include "limber/core/time.hpp"

namespace limber::detail {

using Eigen::Matrix3d;
using Eigen::Vector3d;

GyroAttitude::GyroAttitude(std::span<const ImuSample> imu) : imu_(imu) {
  times_.push_back(0.0);
  attitudes_.emplace_back(Matrix3d::Identity());
  for (std::size_t k = 1; k < imu.size(); ++k) {
    const double dt = seconds_between(imu[k - 1].t_ns, imu[k].t_ns);
    const Vector3d turn = 0.5 * dt * (imu[k - 1].omega_imu + imu[k].omega_imu);
    times_.push_back(seconds_between(imu.front().t_ns, imu[k].t_ns));
    attitudes_.push_back(so3_normalized(attitudes_.back() * so3_exp(turn)));
  }
}

std::optional<std::size_t> GyroAttitude::before(double t_s) const {
  const auto behind = std::ranges::upper_bound(times_, t_s);
  if (behind == times_.begin() || behind == times_.end()) {
    return std::nullopt;
  }
  return static_cast<std::size_t>(std::distance(times_.begin(), behind) - 1);
}

std::optional<Vector3d> GyroAttitude::rate(double t_s) const {
  const auto k = before(t_s);
  if (!k) {
    return std::nullopt;
  }
  const double share = (t_s - times_[*k]) / (times_[*k + 1] - times_[*k]);
  return Vector3d((1.0 - share) * imu_[*k].omega_imu + share * imu_[*k + 1].omega_imu);
}

std::optional<Matrix3d> GyroAttitude::at(double t_s) const {
  const auto k = before(t_s);
  const auto now = rate(t_s);
  if (!k || !now) {
    return std::nullopt;
  }
  return Matrix3d(attitudes_[*k] * so3_exp(0.5 * (t_s - times_[*k]) * (imu_[*k].omega_imu + *now)));
}

std::optional<Vector3d> GyroAttitude::mean_rate(double begin_s, double end_s) const {
  const auto begin = at(begin_s), end = at(end_s);
  if (!begin || !end) {
    return std::nullopt;
  }
  return Vector3d(so3_log(begin->transpose() * *end) / (end_s - begin_s));
}

std::optional<Vector3d> GyroAttitude::mean_samples(double begin_s, double end_s) const {
  const auto begin = std::ranges::lower_bound(times_, begin_s) - times_.begin();
  const auto end = std::ranges::upper_bound(times_, end_s) - times_.begin();
  if (begin >= end) {
    return std::nullopt;
  }
  Vector3d sum = Vector3d::Zero();
  for (const ImuSample& sample :
       imu_.subspan(static_cast<std::size_t>(begin), static_cast<std::size_t>(end - begin))) {
    sum += sample.omega_imu;
  }
  return Vector3d(sum / static_cast<double>(end - begin));
}

double GyroAttitude::sample_time() const { return times_.back() / static_cast<double>(times_.size() - 1); }

}  // namespace limber::detail
