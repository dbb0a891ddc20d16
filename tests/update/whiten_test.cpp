// SPDX-License-Identifier: MIT
#include "limber/update/whiten.hpp"
#include "limber/core/factors.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "check_covariance.hpp"

namespace limber {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using testing::Generator;

TEST(WhitenColumns, IsTheTriangularSolveFromTheRight) {
  Generator generator(17);
  for (const Index m : {1, 2, 7, 8, 9, 15, 16, 17, 24, 31, 64, 65, 100}) {
    for (const Index n : {1, 5, 8, 21, 130}) {
      const MatrixXd A = testing::random_normal(generator, m * m).reshaped(m, m);
      MatrixXd L = Cholesky(multiply(A, transposed(A)) + MatrixXd::Identity(m, m)).L();
      const MatrixXd X = testing::random_normal(generator, n * m).reshaped(n, m);
      MatrixXd white = X;
      const MatrixXd lower = L;
      L.triangularView<Eigen::StrictlyUpper>().setConstant(std::numeric_limits<double>::quiet_NaN());
      whiten_columns(L, white);
      EXPECT_LE((white * lower.transpose() - X).norm(), 1e-11 * (1.0 + X.norm())) << n << "x" << m;
    }
  }
}

TEST(WhitenColumns, OfNothingIsNothing) {
  MatrixXd X(5, 0);
  whiten_columns(MatrixXd(0, 0), X);
  EXPECT_EQ(X.cols(), 0);
  MatrixXd none(0, 9);
  whiten_columns(MatrixXd::Identity(9, 9), none);
  EXPECT_EQ(none.rows(), 0);
}

}  // namespace
}  // namespace limber
