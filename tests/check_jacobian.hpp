// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>

namespace limber::testing {

/// Compares a hand-made Jacobian with central differences of f: R^n -> R^m at zero.
/// `tolerance` is relative to the largest entry of the Jacobian (at least 1).
template <typename Function>
void check_jacobian(const Eigen::MatrixXd& analytic, Function&& f, double tolerance = 1e-6,
                    double step = 1e-6) {
  const Eigen::Index n = analytic.cols();
  Eigen::MatrixXd numeric(analytic.rows(), n);
  for (Eigen::Index k = 0; k < n; ++k) {
    Eigen::VectorXd d = Eigen::VectorXd::Zero(n);
    d(k) = step;
    const Eigen::VectorXd plus = f(d);
    const Eigen::VectorXd minus = f(Eigen::VectorXd(-d));
    numeric.col(k) = (plus - minus) / (2.0 * step);
  }
  const double scale = std::max(1.0, analytic.cwiseAbs().maxCoeff());
  EXPECT_LE((analytic - numeric).cwiseAbs().maxCoeff() / scale, tolerance) << "analytic\n"
                                                                           << analytic << "\nnumeric\n"
                                                                           << numeric;
}

}  // namespace limber::testing
