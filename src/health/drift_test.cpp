// SPDX-License-Identifier: MIT
#include "limber/health/drift_test.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace limber {
namespace {

/// A wave to so many windows: faster ones say less of a line.
constexpr std::size_t kWindowsOfAWave = 4, kFewestWaves = 2, kMostWaves = 9;
/// How many waves a belief is worth: that covariances are right, and that all ways are alike.
constexpr double kWavesOfCovariance = 1.0, kWavesOfAlike = 24.0;
constexpr double kDofOfCovariance = 24.0;  // it rests on about as many cells

}  // namespace

Scatters scatter_of_waves(const std::vector<BetaEstimate>& waves, const ChangeWays& ways) {
  const auto n = static_cast<double>(waves.size());
  std::array<double, std::tuple_size_v<ChangeWays>> sums{};
  double all = 0.0;
  for (std::size_t k = 0; k < ways.size(); ++k) {
    for (const BetaEstimate& wave : waves) {
      const double size = ways[k].along.dot(wave.beta);
      sums[k] += size * size / std::max(ways[k].along.dot(wave.covariance * ways[k].along), 1e-30);
    }
    all += sums[k] / static_cast<double>(ways.size());
  }
  const double alike = (kWavesOfCovariance + all) / (kWavesOfCovariance + n);
  Scatters out;
  for (std::size_t k = 0; k < ways.size(); ++k) {
    out[k] = {(kWavesOfAlike * alike + sums[k]) / (kWavesOfAlike + n),
              1.0 / (1.0 / (kWavesOfAlike + n) + 1.0 / kDofOfCovariance)};
  }
  return out;
}

double chance_of_drift(const std::vector<RigEvidence>& windows, const BetaTrend& trend,
                       const RigParameters& theta, bool metric, const Tolerance& tolerance) {
  const ChangeWays ways = ways_of_change(trend.change.epipolar, theta, metric, tolerance);
  if (!matters(trend.change, ways)) {
    return std::numeric_limits<double>::infinity();
  }
  const std::size_t count =
      std::clamp<std::size_t>(windows.size() / kWindowsOfAWave, kFewestWaves, kMostWaves);
  const Scatters scatters = scatter_of_waves(robust_waves(windows, count), ways);
  return static_cast<double>(ways.size()) * least_chance(trend.change, ways, scatters);
}

double drift_tests_of_window(std::size_t windows) { return 1.0 / std::sqrt(static_cast<double>(windows)); }

}  // namespace limber
