// SPDX-License-Identifier: MIT
#include "check_covariance.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>

#include "limber/core/chi_square.hpp"

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
  const Eigen::LLT<Eigen::MatrixXd> llt(P);
  ASSERT_EQ(llt.info(), Eigen::Success);
  const Eigen::VectorXd mean = llt.matrixL().solve(sum_ / std::sqrt(count_));
  EXPECT_LE(mean.squaredNorm(), chi_square_quantile(1.0 - kFalseAlarm, n));
  const Eigen::MatrixXd half = llt.matrixL().solve(outer_ / count_);
  const Eigen::MatrixXd white = llt.matrixL().solve(half.transpose());
  const Eigen::VectorXd roots =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(white).eigenvalues().cwiseMax(0.0).cwiseSqrt();
  const double t = std::sqrt(2.0 * std::log(2.0 / kFalseAlarm) / count_);
  const double band = std::sqrt(n / count_) + t + slack;
  EXPECT_GE(roots.minCoeff(), 1.0 - band);
  EXPECT_LE(roots.maxCoeff(), 1.0 + band);
}

}  // namespace limber::testing
