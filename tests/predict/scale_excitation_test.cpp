// SPDX-License-Identifier: MIT
#include "limber/predict/scale_excitation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>

namespace limber {
namespace {

using Eigen::Vector3d;

constexpr double kDensity = 0.01;  // [m/s^2/sqrt(Hz)]
constexpr std::int64_t kFrameNs = 50'000'000;

/// What velocity is after a time [s].
template <typename Velocity>
double share_after(double duration_s, Velocity velocity) {
  ScaleExcitation excitation(kDensity);
  for (std::int64_t t_ns = 0; 1e-9 * static_cast<double>(t_ns) <= duration_s; t_ns += kFrameNs) {
    excitation.add(t_ns, velocity(1e-9 * static_cast<double>(t_ns)));
  }
  return excitation.noise_share();
}

TEST(ScaleExcitation, KnowsNothingOfLessThanHalfASecond) {
  EXPECT_EQ(share_after(0.4, [](double) { return Vector3d(1.0, 0.0, 0.0); }), 0.0);
}

TEST(ScaleExcitation, IsNoiseAloneAtConstantVelocity) {
  EXPECT_EQ(share_after(5.0, [](double) { return Vector3d(3.0, 1.0, 0.0); }), 1.0);
}

TEST(ScaleExcitation, OfAVelocityThatNoiseMovesIsAllNoise) {
  std::mt19937 random(3);
  std::normal_distribution<double> gain(0.0, kDensity * std::sqrt(1e-9 * static_cast<double>(kFrameNs)));
  Vector3d v = Vector3d::Zero();
  const double share = share_after(60.0, [&](double) {
    v += Vector3d(gain(random), gain(random), gain(random));
    return v;
  });
  EXPECT_GT(share, 0.6);
}

/// A gain of a m/s^2 over half a second, squared, and that of noise, three axes.
TEST(ScaleExcitation, OfAnAccelerationIsTheRatioOfSquares) {
  for (const double a : {0.1, 1.0}) {
    const double share = share_after(20.0, [&](double t) { return Vector3d(0.0, a * t, 0.0); });
    EXPECT_NEAR(share, 3.0 * kDensity * kDensity * 0.5 / std::pow(0.5 * a, 2), 1e-3 * share);
  }
}

TEST(ScaleExcitation, IsKnownOfTwoFramesInASecond) {
  ScaleExcitation excitation(kDensity);
  for (std::int64_t k = 0; k < 10; ++k) {
    excitation.add(10 * k * kFrameNs, Vector3d(0.0, 0.0, 0.05 * static_cast<double>(k)));
  }
  EXPECT_NEAR(excitation.noise_share(), 3.0 * kDensity * kDensity * 0.5 / std::pow(0.05, 2), 1e-6);
}

TEST(ScaleExcitation, ForgetsWhatWasTensOfSecondsAgo) {
  const double share = share_after(60.0, [&](double t) { return Vector3d(std::min(t, 5.0), 0.0, 0.0); });
  EXPECT_GT(share, 0.05);
}

TEST(ScaleExcitation, AJumpIsNoMotion) {
  ScaleExcitation excitation(kDensity);
  for (std::int64_t k = 0; k < 200; ++k) {
    if (k == 100) {
      excitation.jump();
    }
    excitation.add(k * kFrameNs, Vector3d(k < 100 ? 0.0 : 2.0, 0.0, 0.0));
  }
  EXPECT_EQ(excitation.noise_share(), 1.0);
}

}  // namespace
}  // namespace limber
