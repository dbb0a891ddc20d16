// SPDX-License-Identifier: MIT
#include "limber/core/chi_square.hpp"

#include <cmath>
#include <stdexcept>

namespace limber {
namespace {

constexpr int kMaxTerms = 2000;
constexpr double kEpsilon = 1e-16;

/// Lower regularised incomplete gamma function P(a, x), by series (x < a + 1).
double gamma_p_series(double a, double x) {
  double term = 1.0 / a;
  double sum = term;
  for (int n = 1; n < kMaxTerms && std::abs(term) > kEpsilon * std::abs(sum); ++n) {
    term *= x / (a + n);
    sum += term;
  }
  return sum * std::exp(-x + a * std::log(x) - std::lgamma(a));
}

/// Upper regularised incomplete gamma function Q(a, x), by Lentz's continued fraction (x >= a + 1).
double gamma_q_fraction(double a, double x) {
  constexpr double kTiny = 1e-300;
  double b = x + 1.0 - a;
  double c = 1.0 / kTiny;
  double d = 1.0 / b;
  double h = d;
  for (int i = 1; i < kMaxTerms; ++i) {
    const double an = -i * (i - a);
    b += 2.0;
    d = an * d + b;
    d = 1.0 / (std::abs(d) < kTiny ? kTiny : d);
    c = b + an / c;
    c = std::abs(c) < kTiny ? kTiny : c;
    const double delta = d * c;
    h *= delta;
    if (std::abs(delta - 1.0) < kEpsilon) {
      break;
    }
  }
  return h * std::exp(-x + a * std::log(x) - std::lgamma(a));
}

}  // namespace

double chi_square_cdf(double x, double dof) {
  if (!(dof > 0.0) || !(x >= 0.0)) {
    throw std::invalid_argument("chi_square_cdf: expected dof > 0 and x >= 0");
  }
  if (x == 0.0) {
    return 0.0;
  }
  const double a = 0.5 * dof;
  const double half = 0.5 * x;
  return half < a + 1.0 ? gamma_p_series(a, half) : 1.0 - gamma_q_fraction(a, half);
}

double chi_square_quantile(double probability, double dof) {
  if (!(probability >= 0.0 && probability < 1.0) || !(dof > 0.0)) {
    throw std::invalid_argument("chi_square_quantile: expected 0 <= probability < 1 and dof > 0");
  }
  double low = 0.0;
  double high = dof + 10.0;
  while (chi_square_cdf(high, dof) < probability) {
    high *= 2.0;
  }
  // Bisection to the last bit: called once per gate, never in a loop over points.
  for (int i = 0; i < 200 && high - low > 1e-14 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (chi_square_cdf(middle, dof) < probability ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace limber
