// SPDX-License-Identifier: MIT
#include "limber/health/learned_imu_noise.hpp"

#include <algorithm>
#include <cmath>

namespace limber {

namespace {

constexpr double kShare = 0.1;        // of one frame in the fading mean, as in InputAlarm
constexpr double kNoiseShare = 0.05;  // the same of the noise that other rows show
constexpr double kAllowed = 1.5;      // of the expected square: sound corrections are often larger than usual
constexpr double kMost = 8.0;         // of it: what is larger raises no faster
constexpr double kRate = 0.03;        // of the factor's logarithm, per frame and expected square
constexpr double kLargestFactor = 100.0;
constexpr int kYoung = 10;  // frames: the first ones are corrected by what the start did not know

/// What a factor is multiplied by. @param square  of three numbers, over the expected one
double step(double square) { return std::exp(kRate * (std::min(square, kMost) - kAllowed)); }

}  // namespace

ImuNoiseFactors LearnedImuNoise::bounded(const ImuNoiseFactors& factors) {
  return {std::clamp(factors.gyro, 1.0, kLargestFactor), std::clamp(factors.accel, 1.0, kLargestFactor)};
}

LearnedImuNoise::LearnedImuNoise(const ImuNoiseFactors& begin) : factors_(bounded(begin)) {}

void LearnedImuNoise::learn(const PoseCorrection& c, bool of_accelerometer) {
  if (!c.dx.allFinite() || !c.covariance.allFinite() || c.dof <= 0.0) {
    return;
  }
  const PoseCorrection::Vector6 z = whitened(c);
  const double rest = scatter_beside(c, z);
  noise_ += kNoiseShare * (rest - noise_);
  mean_ = (1.0 - kShare) * mean_ + kShare * z;
  weight_ = (1.0 - kShare) * (1.0 - kShare) * weight_ + kShare * kShare;
  if (++frames_ > kYoung) {
    const double expected = 3.0 * weight_ * std::max({noise_, rest, 1.0});
    const double of_accel = of_accelerometer ? step(mean_.head<3>().squaredNorm() / expected) : 1.0,
                 of_gyro = step(mean_.tail<3>().squaredNorm() / expected);
    factors_ = bounded({factors_.gyro * of_gyro, factors_.accel * of_accel});
  }
}

}  // namespace limber
