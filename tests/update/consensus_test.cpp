// SPDX-License-Identifier: MIT
#include "limber/update/consensus.hpp"

#include <gtest/gtest.h>

#include "check_covariance.hpp"
#include "random_geometry.hpp"

namespace limber {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::Generator;

struct Problem {
  VectorXd r;
  MatrixXd S, A;
  std::vector<RowGroup> groups;
  VectorXd beta;
};

/// Groups of two rows with noise of their own size, moved by a shared offset of a few prior deviations.
Problem consensus_problem(Generator& generator, Index count, Index k) {
  Problem out;
  out.A = 20.0 * MatrixXd(2 * count, k).unaryExpr([&](double) {
    return testing::random_scalar(generator, -1.0, 1.0);
  });
  out.beta = testing::random_normal(generator, k);
  out.S = MatrixXd::Zero(2 * count, 2 * count);
  out.r = out.A * out.beta;
  for (Index g = 0; g < count; ++g) {
    const double sigma = testing::random_scalar(generator, 0.5, 3.0);
    out.S.block<2, 2>(2 * g, 2 * g) << sigma * sigma, 0.3 * sigma * sigma, 0.3 * sigma * sigma, sigma * sigma;
    const Eigen::Matrix2d root = out.S.block<2, 2>(2 * g, 2 * g).llt().matrixL();
    out.r.segment<2>(2 * g) += root * testing::random_normal(generator, 2);
    out.groups.push_back({2 * g, 2, -1});
  }
  return out;
}

TEST(Consensus, IsNotMovedByFortyPerCentOfGrossOutliers) {
  Generator generator(1);
  for (int run = 0; run < 50; ++run) {
    Problem p = consensus_problem(generator, 50, 6);
    for (Index g = 0; g < 20; ++g) {
      p.r.segment<2>(2 * g) += 300.0 * testing::random_normal(generator, 2);
    }
    const Consensus found = find_consensus(white_groups(p.r, p.S, p.A, p.groups), 1.0);
    EXPECT_LE((found.beta - p.beta).norm(), 0.3) << run;
    for (std::size_t g = 20; g < 50; ++g) {
      EXPECT_LE(found.distance[g], 40.0) << run;
    }
  }
}

TEST(Consensus, WithoutSharedDirectionsIsEachGroupsOwnDistance) {
  Generator generator(2);
  const Problem p = consensus_problem(generator, 10, 0);
  const Consensus found = find_consensus(white_groups(p.r, p.S, p.A, p.groups), 1.0);
  EXPECT_EQ(found.beta.size(), 0);
  for (std::size_t g = 0; g < p.groups.size(); ++g) {
    const auto at = static_cast<Index>(2 * g);
    const Eigen::Vector2d e = p.r.segment<2>(at);
    EXPECT_NEAR(found.distance[g], e.dot(p.S.block<2, 2>(at, at).inverse() * e), 1e-9);
  }
}

}  // namespace
}  // namespace limber
