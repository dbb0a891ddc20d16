// SPDX-License-Identifier: MIT
#include "limber/health/drift_test.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace limber {
namespace {

constexpr std::int64_t kWindow_ns = 2'500'000'000;
const RigParameters kTheta = (RigParameters() << 0, 0, 0, -0.12, 0, 0).finished();

/// Windows whose clusters say that each of their errors has variance 1.
/// @param error  of all of beta, in units of that
std::vector<RigEvidence> windows_of(const std::vector<NormalEquations::Vector>& error) {
  constexpr double kVariance = 0.01;  // small beside the prior
  std::vector<RigEvidence> out;
  for (std::size_t k = 0; k < error.size(); ++k) {
    RigEvidence& window = out.emplace_back();
    window.from_ns = static_cast<std::int64_t>(k) * kWindow_ns;
    window.to_ns = window.from_ns + kWindow_ns;
    window.all.information = NormalEquations::Matrix::Identity() / kVariance;
    window.all.vector = error[k] / std::sqrt(kVariance);
    window.products.tracks = window.products.both = window.products.of_a_pixel[0] = window.all.information;
    window.errors.squares[0] = window.errors.weights[0] = 1.0;
    window.epipolar = NormalEquations::Matrix::Identity();
    window.points = 1;
  }
  return out;
}

/// A tolerance so small that everything matters.
Tolerance chance_alone() {
  Tolerance out;
  out.epipolar_px.ok = 1e-6;
  out.depth.ok = 1e-6;
  return out;
}

double chance_of(const std::vector<NormalEquations::Vector>& error) {
  const std::vector<RigEvidence> windows = windows_of(error);
  return chance_of_drift(windows, robust_trend(windows, kTheta, true), kTheta, true, chance_alone());
}

/// Errors of windows that have so much to do with the one before: an autoregressive process of variance 1.
std::vector<NormalEquations::Vector> errors(std::size_t count, double correlation, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  NormalEquations::Vector before;
  std::vector<NormalEquations::Vector> out;
  for (std::size_t n = 0; n < count; ++n) {
    for (Eigen::Index k = 0; k < before.size(); ++k) {
      const double fresh = normal(random);
      before(k) =
          n == 0 ? fresh : correlation * before(k) + std::sqrt(1.0 - correlation * correlation) * fresh;
    }
    out.push_back(before);
  }
  return out;
}

/// Share of sound rigs whose line has a p-value below 1 %.
double false_share(std::size_t windows, double correlation) {
  constexpr unsigned kSeeds = 400;
  int found = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    found += chance_of(errors(windows, correlation, seed)) < 0.01 ? 1 : 0;
  }
  return static_cast<double>(found) / kSeeds;
}

TEST(DriftTest, SoundRigsHaveThePValueThatIsStated) {
  EXPECT_LT(false_share(12, 0.0), 0.02);
  EXPECT_LT(false_share(40, 0.0), 0.02);
}

TEST(DriftTest, WindowsThatHaveToDoWithEachOtherAreNoDrift) {
  EXPECT_LT(false_share(40, 0.4), 0.02);  // some 15 % by the covariance of the line alone
}

TEST(DriftTest, FindsALineAmongThem) {
  int found = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::vector<NormalEquations::Vector> error = errors(40, 0.4, seed);
    for (std::size_t n = 0; n < error.size(); ++n) {
      error[n](5) += 0.15 * static_cast<double>(n);
    }
    found += chance_of(error) < 1e-4 ? 1 : 0;
  }
  EXPECT_GE(found, 19);
}

TEST(DriftTest, NothingThatMattersIsNoDrift) {
  const std::vector<RigEvidence> windows = windows_of(errors(20, 0.0, 1));
  Tolerance wide;
  wide.epipolar_px = {1e3, 1e4};
  wide.depth = {1e3, 1e4};
  EXPECT_TRUE(std::isinf(chance_of_drift(windows, robust_trend(windows, kTheta, true), kTheta, true, wide)));
}

}  // namespace
}  // namespace limber
