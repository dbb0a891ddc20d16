// SPDX-License-Identifier: MIT
#include "limber/predict/scale_excitation.hpp"

#include <algorithm>

#include "limber/core/time.hpp"

namespace limber {
namespace {

/// Over which velocity is gained [s]: about as long as images take to tell the accelerometer's noise apart.
constexpr double kGain = 0.5;
constexpr double kExcitationMemory = 10.0;  // [s]
constexpr double kLongestFrame = 0.75;      // [s] between frames: longer ones are a gap

}  // namespace

ScaleExcitation::ScaleExcitation(double accel_density) : density_(accel_density) {}

void ScaleExcitation::add(std::int64_t t_ns, const Eigen::Vector3d& v_world_body) {
  const double dt = last_.empty() ? 0.0 : seconds_between(last_.back().t_ns, t_ns);
  if (dt > kLongestFrame) {
    last_.clear();
  }
  last_.push_back({t_ns, v_world_body});
  while (last_.size() > 1 && seconds_between(last_[1].t_ns, t_ns) >= kGain) {
    last_.pop_front();
  }
  const double over_s = seconds_between(last_.front().t_ns, t_ns);
  if (over_s < kGain) {
    return;
  }
  const double square = (v_world_body - last_.front().v).squaredNorm() * (kGain / over_s);
  seen_s_ = std::min(seen_s_ + dt, kExcitationMemory);
  mean_square_ += (dt / seen_s_) * (square - mean_square_);
}

double ScaleExcitation::noise_share() const {
  const double noise = 3.0 * density_ * density_ * kGain;
  return seen_s_ == 0.0 ? 0.0 : noise / std::max(mean_square_, noise);
}

}  // namespace limber
