// SPDX-License-Identifier: MIT
#include "limber/predict/learned_odometry_noise.hpp"

#include <algorithm>

namespace limber {
namespace {

constexpr std::size_t kSamples = 4;        // of a third difference
constexpr double kVarianceOfThird = 20.0;  // 1 + 9 + 9 + 1 times that of a sample
constexpr int kMostDifferences = 1000;
constexpr double kUneven = 1.3;     // longest interval of four samples over the shortest
constexpr double kLargest = 25.0;   // of the mean: a larger square is a slip or a jump
constexpr double kSmallest = 1e-5;  // [m/s], [rad/s]: recordings are rounded

Eigen::Matrix<double, 6, 1> value(const OdometrySample& sample) {
  Eigen::Matrix<double, 6, 1> out;
  out << sample.v_body, sample.omega_body;
  return out;
}

}  // namespace

bool LearnedOdometryNoise::evenly_spaced() const {
  double shortest = 1e300, longest = 0.0;
  for (std::size_t k = 1; k < last_.size(); ++k) {
    const auto interval = static_cast<double>(last_[k].t_ns - last_[k - 1].t_ns);
    shortest = std::min(shortest, interval);
    longest = std::max(longest, interval);
  }
  return longest < kUneven * shortest;
}

/// Encoders of wheels that stand still have no noise, and tell nothing of what they have when these turn.
bool LearnedOdometryNoise::rests() const {
  return std::any_of(last_.begin(), last_.end(),
                     [](const OdometrySample& sample) { return value(sample).isZero(0.0); });
}

void LearnedOdometryNoise::add(const OdometrySample& sample) {
  if (!last_.empty() && sample.t_ns <= last_.back().t_ns) {
    return;
  }
  last_.push_back(sample);
  if (last_.size() > kSamples) {
    last_.pop_front();
  }
  for (Eigen::Index k = 0; k < 6; ++k) {
    measured_[static_cast<std::size_t>(k)] |= value(sample)(k) != 0.0;
  }
  if (last_.size() == kSamples && evenly_spaced() && !rests()) {
    learn(value(last_[3]) - value(last_[0]) + 3.0 * (value(last_[1]) - value(last_[2])));
  }
}

void LearnedOdometryNoise::learn(const Vector6& third_difference) {
  Vector6 square = third_difference.cwiseAbs2() / kVarianceOfThird;
  if (!square.allFinite()) {
    return;
  }
  if (knows()) {
    square = square.cwiseMin(kLargest * variance_);
  }
  differences_ = std::min(differences_ + 1, kMostDifferences);
  variance_ += (square - variance_) / differences_;
}

OdometryNoise LearnedOdometryNoise::white() const {
  if (!knows()) {
    return begin_;
  }
  Vector6 sigma = variance_.cwiseSqrt().cwiseMax(kSmallest);
  const Vector6 begin = (Vector6() << begin_.sigma_v, begin_.sigma_omega).finished();
  for (Eigen::Index k = 0; k < 6; ++k) {
    if (!measured_[static_cast<std::size_t>(k)]) sigma(k) = begin(k);
  }
  return {sigma.head<3>(), sigma.tail<3>()};
}

OdometryNoise LearnedOdometryNoise::assumed(double speed) const {
  OdometryNoise out = white();
  if (knows()) {
    out.sigma_v = (out.sigma_v.cwiseAbs2().array() + kLasting * kLasting * speed * speed).sqrt();
  }
  return out;
}

OdometryNoise LearnedOdometryNoise::assumed() const {
  return assumed(last_.empty() ? 0.0 : last_.back().v_body.norm());
}

}  // namespace limber
