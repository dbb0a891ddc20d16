// SPDX-License-Identifier: MIT
#include "smooth/block_tridiagonal.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "random_geometry.hpp"

namespace limber::detail {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Positive definite, blocks of `width` coupled with their neighbours.
MatrixXd random_chain(testing::Generator& generator, Index blocks, Index width) {
  MatrixXd out = MatrixXd::Zero(blocks * width, blocks * width);
  for (Index j = 0; j + 1 < blocks; ++j) {
    const MatrixXd rows = testing::random_normal(generator, 4 * width * width).reshaped(2 * width, 2 * width);
    out.block(j * width, j * width, 2 * width, 2 * width) += rows.transpose() * rows;
  }
  return out + 0.1 * MatrixXd::Identity(out.rows(), out.cols());
}

TEST(BlockTridiagonal, SolvesAndInvertsAsTheDenseMatrixDoes) {
  testing::Generator generator(1);
  for (const Index blocks : {1, 2, 7}) {
    const MatrixXd dense = random_chain(generator, blocks, 3), inverse = dense.inverse();
    const BlockTridiagonal chain(dense.sparseView(), 3);
    ASSERT_TRUE(chain.succeeded());
    ASSERT_EQ(chain.blocks(), blocks);
    MatrixXd B = testing::random_normal(generator, 3 * blocks * 5).reshaped(3 * blocks, 5);
    const MatrixXd expected = inverse * B;
    chain.solve(B);
    EXPECT_LE((B - expected).norm(), 1e-10 * expected.norm());
    const auto diagonal = chain.inverse_diagonal();
    for (Index j = 0; j < blocks; ++j) {
      EXPECT_LE((diagonal[static_cast<std::size_t>(j)] - inverse.block(3 * j, 3 * j, 3, 3)).norm(),
                1e-10 * inverse.norm());
    }
  }
}

TEST(BlockTridiagonal, SaysThatAMatrixIsNotPositiveDefinite) {
  MatrixXd dense = MatrixXd::Identity(6, 6);
  dense(4, 4) = -1.0;
  EXPECT_FALSE(BlockTridiagonal(dense.sparseView(), 3).succeeded());
}

}  // namespace
}  // namespace limber::detail
