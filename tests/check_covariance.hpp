// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "random_geometry.hpp"

namespace limber::testing {

Eigen::VectorXd random_normal(Generator& generator, Eigen::Index n);

/// Collects independent draws of an error and compares them with its predicted covariance P.
///
/// The root of the whitened sample covariance of N draws in n dimensions has its singular values within
/// 1 ± (sqrt(n/N) + t), but for a chance of 2 exp(−N t²/2) (Davidson and Szarek 2001); t is chosen for one in
/// a million, as is the bound on the mean.
class SampleCovariance {
 public:
  explicit SampleCovariance(Eigen::Index n);

  void add(const Eigen::VectorXd& error);

  /// @param slack  what the model may be off besides, as a share of each standard deviation
  void expect(const Eigen::MatrixXd& P, double slack) const;

 private:
  Eigen::VectorXd sum_;
  Eigen::MatrixXd outer_;
  double count_ = 0.0;
};

}  // namespace limber::testing
