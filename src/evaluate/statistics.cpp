// SPDX-License-Identifier: MIT
#include "limber/evaluate/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

#include "limber/core/median.hpp"

namespace limber {
namespace {

constexpr double kTail = 0.025;  // on either side of an interval
constexpr double kLargestCorrelation = 0.9;

/// P(|T| <= sqrt(dof) tan(angle)) of Student's T: the integral of cos^(dof - 1) from 0, over that up to pi/2.
double student_within(double angle, double dof) {
  constexpr int kSteps = 200;  // Simpson's rule
  const double step = angle / kSteps;
  double sum = 0.0;
  for (int k = 0; k <= kSteps; ++k) {
    const double weight = k == 0 || k == kSteps ? 1.0 : (k % 2 == 1 ? 4.0 : 2.0);
    sum += weight * std::pow(std::cos(k * step), dof - 1.0);
  }
  const double whole =
      0.5 * std::sqrt(std::numbers::pi) * std::exp(std::lgamma(0.5 * dof) - std::lgamma(0.5 * (dof + 1.0)));
  return sum * step / 3.0 / whole;
}

/// Correlation of neighbours, with the bias of so few values taken back; 0 to
/// kLargestCorrelation.
double neighbour_correlation(std::span<const double> values, double mean) {
  double squares = 0.0, products = 0.0;
  for (std::size_t k = 0; k < values.size(); ++k) {
    squares += (values[k] - mean) * (values[k] - mean);
    products += k > 0 ? (values[k] - mean) * (values[k - 1] - mean) : 0.0;
  }
  const double r = squares > 0.0 ? products / squares + 1.0 / static_cast<double>(values.size()) : 0.0;
  return std::clamp(r, 0.0, kLargestCorrelation);
}

}  // namespace

double student_quantile(double dof) {
  double low = 0.0, high = 0.5 * std::numbers::pi;
  for (int k = 0; k < 50; ++k) {
    const double middle = 0.5 * (low + high);
    (student_within(middle, dof) < 1.0 - 2.0 * kTail ? low : high) = middle;
  }
  return std::sqrt(dof) * std::tan(low);
}

Statistics statistics_of(std::span<const double> values) {
  if (values.empty()) {
    throw std::invalid_argument("statistics: there are no values");
  }
  std::vector<double> sorted(values.begin(), values.end());
  if (!std::all_of(sorted.begin(), sorted.end(), [](double v) { return std::isfinite(v); })) {
    throw std::invalid_argument("statistics: a value is not finite");
  }
  std::sort(sorted.begin(), sorted.end());

  Statistics s;
  s.count = sorted.size();
  const auto n = static_cast<double>(s.count);
  double sum = 0.0;
  for (double v : sorted) {
    sum += v;
    s.sse += v * v;
  }
  s.mean = sum / n;
  s.rmse = std::sqrt(s.sse / n);
  double deviation = 0.0;
  for (double v : sorted) {
    deviation += (v - s.mean) * (v - s.mean);
  }
  s.std = std::sqrt(deviation / n);
  s.min = sorted.front();
  s.max = sorted.back();
  s.median = median(std::move(sorted));
  return s;
}

std::optional<MedianInterval> median_interval(std::span<const double> values) {
  std::vector<double> sorted(values.begin(), values.end());
  if (std::any_of(sorted.begin(), sorted.end(), [](double v) { return std::isnan(v); })) {
    throw std::invalid_argument("statistics: a value is not a number");
  }
  std::sort(sorted.begin(), sorted.end());
  if (sorted.empty()) {
    return std::nullopt;
  }
  const std::size_t n = sorted.size();
  MedianInterval out{median(sorted), {}, {}};
  // Probability that exactly k of n values lie below the median, and that at most so many do.
  double exactly = std::pow(0.5, static_cast<double>(n)), at_most = exactly;
  for (std::size_t k = 0; at_most <= kTail; ++k) {
    out.lower = sorted[k];
    out.upper = sorted[n - 1 - k];
    exactly *= static_cast<double>(n - k) / static_cast<double>(k + 1);
    at_most += exactly;
  }
  return out;
}

std::optional<MeanInterval> mean_interval(std::span<const double> values) {
  if (values.empty()) {
    return std::nullopt;
  }
  const Statistics s = statistics_of(values);
  MeanInterval out{s.mean, {}, {}, neighbour_correlation(values, s.mean), s.count};
  const auto n = static_cast<double>(s.count);
  const double effective = n * (1.0 - out.correlation) / (1.0 + out.correlation);
  if (s.count >= kFewestForMean) {
    const double half =
        student_quantile(std::max(1.0, effective - 1.0)) * s.std * std::sqrt(n / (n - 1.0) / effective);
    out.lower = s.mean - half;
    out.upper = s.mean + half;
  }
  return out;
}

}  // namespace limber
