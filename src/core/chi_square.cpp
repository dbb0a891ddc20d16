// SPDX-License-Identifier: MIT
#include "limber/core/chi_square.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

namespace limber {
namespace {

constexpr double kEps = std::numeric_limits<double>::epsilon();

// x^a exp(-x) / Gamma(a + 1). For large a through Stirling's series, which never subtracts large logarithms.
double gamma_prefactor(double a, double x) {
  constexpr double kStirlingFrom = 15.0;
  if (a < kStirlingFrom) {
    return std::exp(a * std::log(x) - x) / std::tgamma(a + 1.0);
  }
  const double a2 = a * a;
  const double series = (1.0 / 12.0 - (1.0 / 360.0 - (1.0 / 1260.0 - 1.0 / (1680.0 * a2)) / a2) / a2) / a;
  const double mu = (x - a) / a;
  return std::exp(a * (std::log1p(mu) - mu) - series) / std::sqrt(2.0 * std::numbers::pi * a);
}

// Lower regularised incomplete gamma function P(a, x) by its power series, for x < a + 1. [DLMF], 8.11.4.
double gamma_p_series(double a, double x) {
  double term = 1.0;
  double sum = 1.0;
  for (double n = a + 1.0; term > kEps * sum; n += 1.0) {
    term *= x / n;
    sum += term;
  }
  return gamma_prefactor(a, x) * sum;
}

// Upper Q(a, x) by its continued fraction, for x >= a + 1: modified Lentz algorithm. [DLMF], 8.9.2.
double gamma_q_fraction(double a, double x) {
  constexpr double kTiny = 1e-300;
  double b = x + 1.0 - a;
  double c = 1.0 / kTiny;
  double d = 1.0 / b;
  double fraction = d;
  for (double n = 1.0, factor = 0.0; std::abs(factor - 1.0) > 4.0 * kEps; n += 1.0) {
    const double numerator = -n * (n - a);
    b += 2.0;
    d = numerator * d + b;
    d = 1.0 / (std::abs(d) < kTiny ? kTiny : d);
    c = b + numerator / c;
    c = std::abs(c) < kTiny ? kTiny : c;
    factor = d * c;
    fraction *= factor;
  }
  return a * gamma_prefactor(a, x) * fraction;
}

void check_dof(double dof) {
  if (!(dof > 0.0) || !std::isfinite(dof)) {
    throw std::invalid_argument("chi-square: degrees of freedom must be positive, got " +
                                std::to_string(dof));
  }
}

// Both tails at once, each accurate where it is small.
struct Tails {
  double lower, upper;
};

Tails chi_square_tails(double x, double dof) {
  check_dof(dof);
  if (std::isnan(x)) {
    throw std::invalid_argument("chi-square: the value is not a number");
  }
  if (x <= 0.0) {
    return {0.0, 1.0};
  }
  if (std::isinf(x)) {
    return {1.0, 0.0};
  }
  const double a = 0.5 * dof;
  const double half = 0.5 * x;
  if (half < a + 1.0) {
    const double lower = gamma_p_series(a, half);
    return {lower, 1.0 - lower};
  }
  const double upper = gamma_q_fraction(a, half);
  return {1.0 - upper, upper};
}

// Density of the distribution at x > 0.
double chi_square_density(double x, double dof) {
  const double a = 0.5 * dof;
  return gamma_prefactor(a, 0.5 * x) * a / x;
}

}  // namespace

double chi_square_cdf(double x, double dof) { return chi_square_tails(x, dof).lower; }

double chi_square_survival(double x, double dof) { return chi_square_tails(x, dof).upper; }

double chi_square_quantile(double probability, double dof) {
  check_dof(dof);
  if (!(probability >= 0.0 && probability < 1.0)) {
    throw std::invalid_argument("chi-square: probability must be in [0, 1), got " +
                                std::to_string(probability));
  }
  if (probability == 0.0) {
    return 0.0;
  }
  double low = 0.0;
  double high = dof + 1.0;
  while (chi_square_cdf(high, dof) < probability) {
    low = high;
    high *= 2.0;
  }
  // Newton steps on the smaller tail, bisection where they leave the bracket.
  double x = 0.5 * (low + high);
  for (int i = 0; i < 200 && high - low > kEps * high; ++i) {
    const Tails tails = chi_square_tails(x, dof);
    const double excess = probability < 0.5 ? tails.lower - probability : (1.0 - probability) - tails.upper;
    (excess > 0.0 ? high : low) = x;
    const double next = x - excess / chi_square_density(x, dof);
    const double moved = next > low && next < high ? next : 0.5 * (low + high);
    if (std::abs(moved - x) <= kEps * x) {
      return moved;
    }
    x = moved;
  }
  return x;
}

double student_survival(double t, double dof) {
  const double z2 = dof * std::log1p(t * t / dof);
  const double factor = (8.0 * dof + 1.0) / (8.0 * dof + 3.0);
  return chi_square_survival(factor * factor * z2, 1.0);
}

}  // namespace limber
