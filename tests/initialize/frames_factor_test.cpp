// SPDX-License-Identifier: MIT
#include "initialize/frames_factor.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <cstdlib>

#include "check_covariance.hpp"

namespace limber::detail {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Positive definite, dense but for the chain, which knows poses and chains of the neighbouring frames alone.
/// Above the diagonal NaN.
MatrixXd normal_matrix(const FrameLayout& layout, limber::testing::Generator& generator) {
  const Index n = layout.frames * layout.size();
  const auto frame = [&](Index i) { return i / layout.size(); };
  const auto in_frame = [&](Index i) { return i % layout.size(); };
  const auto of_chain = [&](Index i) {
    return in_frame(i) >= layout.pose && in_frame(i) < layout.pose + layout.chain;
  };
  const auto of_theta = [&](Index i) { return in_frame(i) >= layout.pose + layout.chain; };
  MatrixXd S(n, n);
  for (Index j = 0; j < n; ++j) {
    S.col(j) = limber::testing::random_normal(generator, n);
    for (Index i = 0; i < n; ++i) {
      if ((of_chain(i) || of_chain(j)) && (std::abs(frame(i) - frame(j)) > 1 || of_theta(i) || of_theta(j))) {
        S(i, j) = 0.0;
      }
    }
    S(j, j) = 3.0 * static_cast<double>(n);  // outweighs the rest of its row
    S.col(j).head(j).setConstant(std::nan(""));
  }
  return S;
}

/// S, all of it, as FramesFactor is given it.
MatrixXd dense(const MatrixXd& A, double damping, const MatrixXd& of_rest, const FrameLayout& layout) {
  MatrixXd S = A.selfadjointView<Eigen::Lower>();
  S.diagonal() *= 1.0 + damping;
  const std::vector<Index> rest = layout.rest();
  S(rest, rest) -= of_rest;
  return S;
}

TEST(FramesFactor, SolvesAndInvertsAsADenseFactorDoes) {
  limber::testing::Generator generator(5);
  // Without theta, with it, one frame, two, many, without a pose.
  for (const FrameLayout layout :
       {FrameLayout{7, 6, 9, 0}, FrameLayout{6, 6, 9, 6}, FrameLayout{1, 6, 9, 6}, FrameLayout{2, 6, 6, 3},
        FrameLayout{19, 6, 9, 3}, FrameLayout{5, 0, 3, 1}}) {
    const MatrixXd A = normal_matrix(layout, generator);
    const VectorXd g = limber::testing::random_normal(generator, A.rows());
    const MatrixXd root = MatrixXd::NullaryExpr(layout.rest_size(), layout.rest_size(), [&] {
      return limber::testing::random_normal(generator, 1)[0];
    });
    const MatrixXd of_rest = 0.1 * (root + root.transpose());
    const FramesFactor factor(A, 0.1, of_rest, layout);
    ASSERT_TRUE(factor.succeeded());
    const auto llt = dense(A, 0.1, of_rest, layout).llt();
    const VectorXd x = llt.solve(g);
    EXPECT_LT((factor.solve(g) - x).norm(), 1e-12 * x.norm());
    const MatrixXd inverse = llt.solve(MatrixXd::Identity(A.rows(), A.cols()));
    EXPECT_LT((factor.inverse() - inverse).norm(), 1e-12 * inverse.norm());
  }
}

TEST(FramesFactor, SaysWhereAMatrixIsNotPositiveDefinite) {
  limber::testing::Generator generator(6);
  const FrameLayout layout{5, 6, 9, 6};
  for (const Index at : {0, 7, 50, 104}) {  // a pose, chains, the last theta
    MatrixXd A = normal_matrix(layout, generator);
    A(at, at) = -1.0;
    const MatrixXd none = MatrixXd::Zero(layout.rest_size(), layout.rest_size());
    EXPECT_FALSE(FramesFactor(A, 0.0, none, layout).succeeded()) << at;
  }
}

}  // namespace
}  // namespace limber::detail
