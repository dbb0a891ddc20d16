// SPDX-License-Identifier: MIT
#include "limber/health/learned_imu_noise.hpp"

#include <algorithm>
#include <cmath>

namespace limber {

namespace {

constexpr double kAllowed = 1.5;  // of the expected square: sound corrections are often larger than usual
constexpr double kMost = 8.0;     // of it: what is larger raises no faster
constexpr double kRate = 0.03;    // of the factor's logarithm, per frame and expected square
constexpr double kLargestFactor = 100.0;

/// What a factor is multiplied by. @param square  of three numbers, over the expected one
double step(double square) { return std::exp(kRate * (std::min(square, kMost) - kAllowed)); }

}  // namespace

ImuNoiseFactors LearnedImuNoise::bounded(const ImuNoiseFactors& factors) {
  return {std::clamp(factors.gyro, 1.0, kLargestFactor), std::clamp(factors.accel, 1.0, kLargestFactor)};
}

LearnedImuNoise::LearnedImuNoise(const ImuNoiseFactors& begin) : begin_(bounded(begin)), factors_(begin_) {}

void LearnedImuNoise::learn(const PoseCorrection& c, bool trusts_length) {
  if (corrections_.add(c) && !corrections_.are_of_a_start()) {
    const PoseCorrection::Vector6& mean = corrections_.mean();
    const double expected = 3.0 * corrections_.expected_square() * corrections_.noise();
    const double gyro = factors_.gyro * step(mean.tail<3>().squaredNorm() / expected);
    const double accel = factors_.accel * step(mean.head<3>().squaredNorm() / expected);
    factors_ = bounded({gyro, trusts_length ? std::min(accel, std::max(begin_.gyro, begin_.accel)) : accel});
  }
}

}  // namespace limber
