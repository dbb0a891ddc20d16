// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "limber/core/chi_square.hpp"
#include "random_geometry.hpp"

namespace limber::testing {

inline Eigen::VectorXd random_normal(Generator& generator, Eigen::Index n) {
  std::normal_distribution<double> draw;
  return Eigen::VectorXd::NullaryExpr(n, [&] { return draw(generator); });
}

/// Collects independent draws of an error and compares them with its predicted covariance P.
///
/// The root of the whitened sample covariance of N draws in n dimensions has its singular values within
/// 1 ± (sqrt(n/N) + t), but for a chance of 2 exp(−N t²/2) (Davidson and Szarek 2001); t is chosen for one in
/// a million, as is the bound on the mean.
class SampleCovariance {
 public:
  explicit SampleCovariance(Eigen::Index n)
      : sum_(Eigen::VectorXd::Zero(n)), outer_(Eigen::MatrixXd::Zero(n, n)) {}

  void add(const Eigen::VectorXd& error) {
    sum_ += error;
    outer_ += error * error.transpose();
    count_ += 1.0;
  }

  /// @param slack  what the model may be off besides, as a share of each standard deviation
  void expect(const Eigen::MatrixXd& P, double slack) const {
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

 private:
  Eigen::VectorXd sum_;
  Eigen::MatrixXd outer_;
  double count_ = 0.0;
};

}  // namespace limber::testing
