// SPDX-License-Identifier: MIT
#include "limber/predict/motion_seen.hpp"

#include <algorithm>
#include <cmath>

#include "limber/core/time.hpp"

namespace limber {
namespace {

constexpr double kMemory = 20.0;       // [s]
constexpr double kPriorWeight = 1.0;   // [s]
constexpr double kLag = 0.05;          // [s], long enough for noise not to look like motion
constexpr double kLongestStep = 0.25;  // [s], a gap shows no rate of change

}  // namespace

MotionSeen::MotionSeen(double spread, double rate)
    : weight_(kPriorWeight),
      rate_weight_(kPriorWeight),
      squares_(Eigen::Vector3d::Constant(kPriorWeight * spread * spread)),
      rate_squares_(Eigen::Vector3d::Constant(kPriorWeight * rate * rate)) {}

void MotionSeen::add(std::int64_t t_ns, const Eigen::Vector3d& value) {
  if (last_ns_ == std::numeric_limits<std::int64_t>::min()) {
    last_ns_ = reference_ns_ = t_ns;
    reference_ = value;
    return;
  }
  const double dt = std::min(seconds_between(last_ns_, t_ns), kLongestStep);
  last_ns_ = t_ns;
  const double kept = 1.0 - dt / kMemory;
  weight_ = kept * weight_ + dt;
  sum_ = kept * sum_ + dt * value;
  squares_ = kept * squares_ + dt * value.cwiseAbs2();
  const double lag = seconds_between(reference_ns_, t_ns);
  if (lag >= kLag) {
    if (lag <= kLongestStep) {
      const double rate_kept = 1.0 - lag / kMemory;
      rate_weight_ = rate_kept * rate_weight_ + lag;
      rate_squares_ = rate_kept * rate_squares_ + lag * ((value - reference_) / lag).cwiseAbs2();
    }
    reference_ = value;
    reference_ns_ = t_ns;
  }
}

void MotionSeen::shift(std::int64_t by_ns) {
  if (last_ns_ != std::numeric_limits<std::int64_t>::min()) {
    last_ns_ += by_ns;
    reference_ns_ += by_ns;
  }
}

double MotionSeen::spread() const {
  const Eigen::Vector3d variance = squares_ / weight_ - (sum_ / weight_).cwiseAbs2();
  return std::sqrt(std::max(variance.maxCoeff(), 0.0));
}

double MotionSeen::rms() const { return std::sqrt((squares_ / weight_).maxCoeff()); }

double MotionSeen::rate() const { return std::sqrt((rate_squares_ / rate_weight_).maxCoeff()); }

double MotionSeen::correlation(double tau, double spread) const {
  const double change = rate() * tau;
  return spread > 0.0 ? std::max(1.0 - 0.5 * change * change / (spread * spread), 0.0) : 1.0;
}

}  // namespace limber
