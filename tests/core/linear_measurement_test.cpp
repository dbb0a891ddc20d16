// SPDX-License-Identifier: MIT
#include "limber/core/linear_measurement.hpp"

#include <gtest/gtest.h>

#include "random_geometry.hpp"

namespace limber {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using testing::Generator;

constexpr Index kStates = 12;

/// Groups of 2 or 4 rows, each row pair with three blocks of H, two of them in one place.
LinearMeasurement random_measurement(Generator& generator, Index parameters) {
  LinearMeasurement z;
  Index m = 0;
  for (const Index rows : {4, 2, 4, 4, 2}) {
    z.groups.push_back({m, rows});
    m += rows;
  }
  const auto random = [&] { return testing::random_scalar(generator, -1.0, 1.0); };
  z.residual = Eigen::VectorXd::NullaryExpr(m, random);
  z.sigma = Eigen::VectorXd::NullaryExpr(m, random).cwiseAbs();
  z.D = MatrixXd::NullaryExpr(parameters > 0 ? m : 0, parameters, random);
  for (Index row = 0; row < m; row += 2) {
    for (const Index col : {Index{0}, Index{3}, Index{3}}) {
      z.H.blocks.push_back({row, col + 3 * (row % 3), Eigen::Matrix<double, 2, 3>::NullaryExpr(random)});
    }
  }
  return z;
}

TEST(SparseJacobian, BlocksThatShareAPlaceAddUp) {
  SparseJacobian H;
  const auto one = Eigen::Matrix<double, 2, 3>::Ones();
  H.blocks = {{0, 0, one}, {0, 0, 2.0 * one}, {2, 3, 4.0 * one}};
  MatrixXd expected = MatrixXd::Zero(4, 9);
  expected.block<2, 3>(0, 0).setConstant(3.0);
  expected.block<2, 3>(2, 3).setConstant(4.0);
  EXPECT_EQ(H.dense(4, 9), expected);
}

TEST(LinearMeasurement, SubsetKeepsTheRowsOfTheGroupsKept) {
  Generator generator(1);
  for (const Index parameters : {Index{6}, Index{0}}) {
    const LinearMeasurement z = random_measurement(generator, parameters);
    for (unsigned mask = 0; mask < 32; ++mask) {
      std::vector<bool> kept;
      std::vector<Index> rows;
      for (std::size_t g = 0; g < z.groups.size(); ++g) {
        kept.push_back((mask >> g) % 2 == 1);
        for (Index k = 0; kept[g] && k < z.groups[g].rows; ++k) {
          rows.push_back(z.groups[g].row + k);
        }
      }
      const LinearMeasurement part = z.subset(kept);
      ASSERT_EQ(part.rows(), static_cast<Index>(rows.size()));
      EXPECT_EQ(part.residual, z.residual(rows));
      EXPECT_EQ(part.sigma, z.sigma(rows));
      EXPECT_EQ(part.D.cols(), parameters);
      if (parameters > 0) {
        EXPECT_EQ(part.D, z.D(rows, Eigen::all));
      }
      EXPECT_EQ(part.H.dense(part.rows(), kStates), z.H.dense(z.rows(), kStates)(rows, Eigen::all));
    }
  }
}

TEST(LinearMeasurement, GroupsOfASubsetPartitionItsRowsInOrder) {
  Generator generator(2);
  const LinearMeasurement part = random_measurement(generator, 6).subset({true, false, true, false, true});
  ASSERT_EQ(part.groups.size(), 3U);
  EXPECT_EQ(part.groups[0].row, 0);
  EXPECT_EQ(part.groups[0].rows, 4);
  EXPECT_EQ(part.groups[1].row, 4);
  EXPECT_EQ(part.groups[1].rows, 4);
  EXPECT_EQ(part.groups[2].row, 8);
  EXPECT_EQ(part.groups[2].rows, 2);
}

}  // namespace
}  // namespace limber
