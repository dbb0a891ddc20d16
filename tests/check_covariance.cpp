// SPDX-License-Identifier: MIT
#include "check_covariance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "limber/core/chi_square.hpp"
#include "limber/core/factors.hpp"

namespace limber::testing {

Eigen::VectorXd random_normal(Generator& generator, Eigen::Index n) {
  std::normal_distribution<double> draw;
  return Eigen::VectorXd::NullaryExpr(n, [&] { return draw(generator); });
}

SampleCovariance::SampleCovariance(Eigen::Index n)
    : sum_(Eigen::VectorXd::Zero(n)), outer_(Eigen::MatrixXd::Zero(n, n)) {}

void SampleCovariance::add(const Eigen::VectorXd& error) {
  sum_ += error;
  outer_ += error * error.transpose();
  count_ += 1.0;
}

void SampleCovariance::expect(const Eigen::MatrixXd& P, double slack) const {
  constexpr double kFalseAlarm = 1e-6;
  const double n = static_cast<double>(P.rows());
  const Cholesky cholesky(P);
  ASSERT_TRUE(cholesky.succeeded());
  Eigen::VectorXd mean = sum_ / std::sqrt(count_);
  solve_lower(cholesky.factor(), mean);
  EXPECT_LE(mean.squaredNorm(), chi_square_quantile(1.0 - kFalseAlarm, n));
  Eigen::MatrixXd white = outer_ / count_;
  solve_lower(cholesky.factor(), white);
  solve_lower_from_right(transposed(cholesky.factor()), white);
  const Eigen::VectorXd roots = symmetric_eigen(white).values.cwiseMax(0.0).cwiseSqrt();
  const double t = std::sqrt(2.0 * std::log(2.0 / kFalseAlarm) / count_);
  const double band = std::sqrt(n / count_) + t + slack;
  EXPECT_GE(roots.minCoeff(), 1.0 - band);
  EXPECT_LE(roots.maxCoeff(), 1.0 + band);
}

}  // namespace limber::testing
