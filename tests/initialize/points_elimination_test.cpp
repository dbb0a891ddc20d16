// SPDX-License-Identifier: MIT
#include "initialize/points_elimination.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>

#include "random_matrix.hpp"

namespace limber::detail {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Points that come and go: each is known to the frames from its first sighting to its last.
WindowNormal equations(const FrameLayout& layout, std::size_t points, limber::testing::Generator& generator) {
  WindowNormal out;
  out.layout = layout;
  out.W = MatrixXd::Zero(layout.rest_size(), static_cast<Index>(3 * points));
  out.g_points = limber::testing::random_normal(generator, out.W.cols());
  for (std::size_t j = 0; j < points; ++j) {
    const auto first = static_cast<Index>(j * 7 % static_cast<std::size_t>(layout.frames));
    const Index last = std::min(first + static_cast<Index>(j % 5), layout.frames - 1);
    out.seen.push_back({first, last});
    for (Index column = static_cast<Index>(3 * j); column < static_cast<Index>(3 * j + 3); ++column) {
      for (Index k = first; k <= last; ++k) {
        out.W.col(column).segment(layout.pose_in_rest(k), layout.pose) =
            limber::testing::random_normal(generator, layout.pose);
        out.W.col(column).segment(layout.theta_in_rest(k), layout.theta) =
            limber::testing::random_normal(generator, layout.theta);
      }
    }
    Matrix3d root;
    for (Index i = 0; i < 3; ++i) {
      root.col(i) = limber::testing::random_normal(generator, 3);
    }
    out.V.emplace_back(root * root.transpose() + Matrix3d::Identity());
  }
  return out;
}

MatrixXd dense(const std::vector<Matrix3d>& blocks, double damping) {
  const auto n = static_cast<Index>(3 * blocks.size());
  MatrixXd out = MatrixXd::Zero(n, n);
  for (std::size_t j = 0; j < blocks.size(); ++j) {
    out.block<3, 3>(static_cast<Index>(3 * j), static_cast<Index>(3 * j)) = blocks[j];
  }
  out.diagonal() *= 1.0 + damping;
  return out;
}

TEST(PointsElimination, IsThatOfTheDenseMatrices) {
  limber::testing::Generator generator(8);
  // With theta and without; fewer points than go at a time, more, and none.
  for (const Index theta : {0, 3}) {
    for (const std::size_t points : {0u, 5u, 16u, 70u}) {
      const WindowNormal normal = equations({9, 6, 9, theta}, points, generator);
      const PointsElimination points_of(normal, 0.2);
      const MatrixXd inverse = dense(normal.V, 0.2).inverse();
      const MatrixXd expected = normal.W * inverse * normal.W.transpose();
      const MatrixXd lower = (points_of.from_matrix() - expected).triangularView<Eigen::Lower>();
      EXPECT_LE(lower.norm(), 1e-12 * expected.norm());
      const VectorXd step = limber::testing::random_normal(generator, normal.W.rows());
      const VectorXd of_gradient = normal.W * inverse * normal.g_points;
      const VectorXd of_step = inverse * (normal.g_points - normal.W.transpose() * step);
      EXPECT_LE((points_of.from_gradient() - of_gradient).norm(), 1e-12 * of_gradient.norm());
      EXPECT_LE((points_of.step(step) - of_step).norm(), 1e-12 * of_step.norm());
      const VectorXd alone = inverse * normal.g_points;
      EXPECT_LE((points_of.step_alone() - alone).norm(), 1e-12 * alone.norm());
    }
  }
}

}  // namespace
}  // namespace limber::detail
