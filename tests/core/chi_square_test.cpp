// SPDX-License-Identifier: MIT
#include "limber/core/chi_square.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace limber {
namespace {

// P(X > x) for an even number of degrees of freedom: the Poisson sum, a closed form.
double survival_even(double x, int dof) {
  double term = std::exp(-0.5 * x);
  double sum = term;
  for (int k = 1; k < dof / 2; ++k) {
    term *= 0.5 * x / k;
    sum += term;
  }
  return sum;
}

TEST(ChiSquare, QuantilesAreThoseOfThePublishedTables) {
  // Abramowitz and Stegun, Table 26.8, to the digits printed there.
  struct Row {
    double probability, dof, quantile;
  };
  for (const Row& row :
       {Row{0.95, 1, 3.84146}, Row{0.99, 1, 6.63490}, Row{0.95, 2, 5.99146}, Row{0.95, 3, 7.81473},
        Row{0.99, 3, 11.3449}, Row{0.95, 6, 12.5916}, Row{0.99, 6, 16.8119}, Row{0.025, 6, 1.237347},
        Row{0.975, 6, 14.4494}, Row{0.025, 10, 3.24697}, Row{0.975, 10, 20.4831}, Row{0.5, 30, 29.3360},
        Row{0.95, 100, 124.342}, Row{0.005, 100, 67.3276}}) {
    EXPECT_NEAR(chi_square_quantile(row.probability, row.dof), row.quantile, 1e-5 * row.quantile)
        << "p " << row.probability << " dof " << row.dof;
  }
}

TEST(ChiSquare, OneDegreeOfFreedomIsASquaredNormal) {
  for (double x : {1e-6, 0.1, 1.0, 3.0, 9.0, 40.0, 200.0}) {
    EXPECT_NEAR(chi_square_survival(x, 1.0) / std::erfc(std::sqrt(0.5 * x)), 1.0, 1e-12) << x;
    EXPECT_NEAR(chi_square_cdf(x, 1.0) / std::erf(std::sqrt(0.5 * x)), 1.0, 1e-12) << x;
  }
}

TEST(ChiSquare, EvenDegreesOfFreedomMatchThePoissonSum) {
  for (int dof : {2, 4, 6, 30, 32, 120, 600}) {
    for (double ratio : {0.5, 0.9, 1.0, 1.1, 1.5}) {
      const double x = ratio * dof;
      EXPECT_NEAR(chi_square_survival(x, dof) / survival_even(x, dof), 1.0, 2e-12) << dof << " " << ratio;
    }
  }
}

TEST(ChiSquare, TailsAddUpToOne) {
  for (double dof : {0.5, 1.0, 7.0, 1e3, 1e6}) {
    for (double ratio : {0.2, 0.99, 1.0, 1.01, 2.0}) {
      EXPECT_NEAR(chi_square_cdf(ratio * dof, dof) + chi_square_survival(ratio * dof, dof), 1.0, 1e-14);
    }
  }
}

TEST(ChiSquare, LargeDegreesOfFreedomApproachTheNormal) {
  // Wilson-Hilferty's cube root is normal to about 1e-8 at this size; z for 97.5 % is 1.959964.
  const double dof = 1e6;
  const double cube_root = 1.0 - 2.0 / (9.0 * dof) + 1.959963984540054 * std::sqrt(2.0 / (9.0 * dof));
  EXPECT_NEAR(chi_square_quantile(0.975, dof) / (dof * std::pow(cube_root, 3)), 1.0, 1e-8);
}

TEST(ChiSquare, TheFarTailKeepsItsDigits) {
  EXPECT_NEAR(chi_square_survival(1000.0, 2.0) / std::exp(-500.0), 1.0, 1e-12);
  EXPECT_EQ(chi_square_survival(1e6, 2.0), 0.0);
  EXPECT_EQ(chi_square_survival(std::numeric_limits<double>::infinity(), 3.0), 0.0);
}

TEST(ChiSquare, QuantileInvertsTheDistribution) {
  for (double dof : {0.5, 1.0, 2.0, 6.0, 47.0, 3000.0}) {
    for (double p : {1e-10, 1e-3, 0.2, 0.5, 0.9, 0.999, 1.0 - 1e-9}) {
      const double x = chi_square_quantile(p, dof);
      const double back = p < 0.5 ? chi_square_cdf(x, dof) / p : chi_square_survival(x, dof) / (1.0 - p);
      EXPECT_NEAR(back, 1.0, 1e-11) << "p " << p << " dof " << dof;
    }
  }
  EXPECT_EQ(chi_square_quantile(0.0, 3.0), 0.0);
}

/// Values of scipy.stats.t.
TEST(Student, IsNearTheTablesInTheTailsToo) {
  EXPECT_NEAR(student_survival(2.0, 5.0) / 0.101939, 1.0, 0.01);
  EXPECT_NEAR(student_survival(-4.47, 5.0) / 0.00657926, 1.0, 0.05);
  EXPECT_NEAR(student_survival(4.47, 24.0) / 1.598558e-4, 1.0, 0.01);
  EXPECT_NEAR(student_survival(8.0, 24.0) / 3.156001e-8, 1.0, 0.04);
  EXPECT_EQ(student_survival(0.0, 24.0), 1.0);
  EXPECT_THROW((void)student_survival(std::numeric_limits<double>::quiet_NaN(), 24.0), std::invalid_argument);
}

TEST(ChiSquare, RefusesWhatHasNoMeaning) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)chi_square_cdf(1.0, 0.0), std::invalid_argument);
  EXPECT_THROW((void)chi_square_cdf(nan, 1.0), std::invalid_argument);
  EXPECT_THROW((void)chi_square_survival(1.0, -2.0), std::invalid_argument);
  EXPECT_THROW((void)chi_square_survival(1.0, nan), std::invalid_argument);
  EXPECT_THROW((void)chi_square_quantile(1.0, 3.0), std::invalid_argument);
  EXPECT_THROW((void)chi_square_quantile(-0.1, 3.0), std::invalid_argument);
  EXPECT_THROW((void)chi_square_quantile(nan, 3.0), std::invalid_argument);
}

}  // namespace
}  // namespace limber
