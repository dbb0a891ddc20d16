// SPDX-License-Identifier: MIT
#include "limber/health/change_test.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "limber/core/chi_square.hpp"
#include "limber/core/factors.hpp"

namespace limber {
namespace {

constexpr std::size_t kMostSteps = 240;  // that are kept of a length
/// What is believed before there are earlier steps, and how many of them that is worth: that covariances are
/// right; that all ways are alike; how far the tails reach beyond Gaussian ones (Student's with 24 degrees).
constexpr double kWorthCovariance = 1.0, kWorthAlike = 24.0;
constexpr double kExcess = 0.3, kWorthExcess = 200.0;
constexpr double kLeastExcess = 0.02;  // kurtosis less than Gaussian is none
constexpr double kLargest = 25.0;      // square by its robust mean: larger ones count as this
constexpr double kMedianOfSquare = 0.455;

/// Of z, whose squares are given: mean square, and kurtosis.
struct Moments {
  double second = 0.0, kurtosis = 0.0;
};

/// @param count  squares that count, the first ones
template <typename Squares>
Moments moments_of(const std::vector<Squares>& squares, std::size_t count, std::size_t way) {
  if (count == 0) {
    return {};
  }
  std::vector<double> z2(count);
  std::transform(squares.begin(), squares.begin() + static_cast<std::ptrdiff_t>(count), z2.begin(),
                 [way](const Squares& one) { return one.by_variance[way]; });
  const auto middle = z2.begin() + static_cast<std::ptrdiff_t>(count / 2);
  std::nth_element(z2.begin(), middle, z2.end());
  const double largest = kLargest * *middle / kMedianOfSquare;
  double sum = 0.0, of_squares = 0.0;
  for (const double square : z2) {
    const double counted = std::min(square, largest);
    sum += counted;
    of_squares += counted * counted;
  }
  const auto n = static_cast<double>(count);
  return {sum / n, n * of_squares / std::max(sum * sum, 1e-30)};
}

}  // namespace

ChangeWays ways_of_change(const NormalEquations::Matrix& epipolar, const RigParameters& theta, bool metric,
                          const Tolerance& tolerance) {
  ChangeWays out;
  out[0].along.head<6>() =
      visible_slope(theta, metric, tolerance).cwiseProduct(plausible_error(theta.tail<3>().norm()));
  out[0].relevant = kRelevantShare * tolerance.depth.ok;
  const SymmetricEigen ways = symmetric_eigen(epipolar);
  for (std::size_t k = 1; k < out.size(); ++k) {
    const Eigen::Index at = NormalEquations::kSize - static_cast<Eigen::Index>(k);
    const double px = std::sqrt(std::max(ways.values(at), 0.0));
    out[k] = {ways.vectors.col(at), kRelevantShare * tolerance.epipolar_px.ok / std::max(px, 1e-12)};
  }
  return out;
}

bool matters(const BetaEstimate& change, const ChangeWays& ways) {
  return std::ranges::any_of(
      ways, [&](const ChangeWay& way) { return std::abs(way.along.dot(change.beta)) > way.relevant; });
}

double least_chance(const BetaEstimate& change, const ChangeWays& ways, const Scatters& scatters) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < ways.size(); ++k) {
    const double size = std::abs(ways[k].along.dot(change.beta));
    if (size > ways[k].relevant) {
      const double variance = scatters[k].factor * ways[k].along.dot(change.covariance * ways[k].along);
      least = std::min(least, student_survival(size / std::sqrt(std::max(variance, 1e-30)), scatters[k].dof));
    }
  }
  return least;
}

void EarlierSteps::add(std::size_t length, const BetaEstimate& step) {
  std::deque<Step>& kept = steps_[length - kShortestStep];
  kept.push_back({window_, step.beta, step.covariance});
  if (kept.size() > kMostSteps) {
    kept.pop_front();
  }
}

StepScatter EarlierSteps::along(const ChangeWays& ways) const {
  StepScatter out;
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    for (const Step& step : steps_[i]) {
      StepScatter::Squares& squares = out.squares_[i].emplace_back();
      squares.age = window_ + 1 - step.window;
      for (std::size_t k = 0; k < ways.size(); ++k) {
        const double size = ways[k].along.dot(step.beta);
        const double variance = ways[k].along.dot(step.covariance * ways[k].along);
        squares.by_variance[k] = size * size / std::max(variance, 1e-30);
      }
    }
  }
  return out;
}

const ScattersByLength& StepScatter::before(std::size_t windows) {
  const auto [at, is_new] = known_.try_emplace(windows);
  ScattersByLength& out = at->second;
  if (!is_new) {
    return out;
  }
  double excess = kWorthExcess * kExcess, worth = kWorthExcess;
  std::array<double, std::tuple_size_v<ScattersByLength>> independent{};
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto length = static_cast<double>(kShortestStep + i);
    const auto count = static_cast<std::size_t>(std::ranges::count_if(
        squares_[i], [windows](const Squares& squares) { return squares.age >= windows; }));
    // Steps that are k windows apart correlate by 1 - k / length: count^2 / (sum of squared correlations).
    const double n = independent[i] =
        static_cast<double>(count) * 3.0 * length / (2.0 * length * length + 1.0);
    Moments all;
    std::array<Moments, std::tuple_size_v<Scatters>> by_way;
    for (std::size_t k = 0; k < by_way.size(); ++k) {
      by_way[k] = moments_of(squares_[i], count, k);
      all.second += by_way[k].second / static_cast<double>(by_way.size());
      all.kurtosis += by_way[k].kurtosis / static_cast<double>(by_way.size());
    }
    const double alike = (kWorthCovariance + n * all.second) / (kWorthCovariance + n);
    for (std::size_t k = 0; k < by_way.size(); ++k) {
      out[i][k].factor = (kWorthAlike * alike + n * by_way[k].second) / (kWorthAlike + n);
    }
    // Gaussian ones have 3 n / (n + 2).
    excess += static_cast<double>(by_way.size()) * (all.kurtosis * (n + 2.0) - 3.0 * n);
    worth += static_cast<double>(by_way.size()) * n;
  }
  const double of_tails = 4.0 + 6.0 / std::max(excess / worth, kLeastExcess);
  for (std::size_t i = 0; i < out.size(); ++i) {
    for (Scatter& scatter : out[i]) {
      scatter.dof = 1.0 / (1.0 / (kWorthAlike + independent[i]) + 1.0 / of_tails);
    }
  }
  return out;
}

}  // namespace limber
