// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/SVD>

#include "limber/update/constraint.hpp"
#include "stereo_problem.hpp"

namespace limber {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using testing::Generator;

MatrixXd random_matrix(Generator& generator, Index rows, Index cols) {
  return MatrixXd::NullaryExpr(rows, cols, [&] { return testing::random_scalar(generator, -1.0, 1.0); });
}

/// A matrix, its rank, and how large it is.
struct Case {
  std::string name;
  MatrixXd D;
  Index rank;
};

std::vector<Case> cases(Generator& generator) {
  std::vector<Case> out;
  for (const Index m : {2, 4, 6, 8, 20, 60}) {
    const Index rank = std::min<Index>(m, 6);
    out.push_back({"full", random_matrix(generator, m, 6), rank});
    MatrixXd sparse = random_matrix(generator, 2 * m, 6);
    for (Index row = 0; row < 2 * m; row += 4) {
      sparse.middleRows(row, 2).setZero();  // left-camera rows
    }
    out.push_back({"every other pair of rows", sparse, rank});
    MatrixXd first(3 * m, 6);
    first << sparse.topRows(m), MatrixXd::Zero(2 * m, 6);
    out.push_back({"zeros at the end", first, std::min<Index>(6, 2 * (m / 4))});
    const MatrixXd thin = random_matrix(generator, m, std::min<Index>(m, 3)) *
                          random_matrix(generator, std::min<Index>(m, 3), 6);
    out.push_back({"rank three", thin, std::min<Index>(m, 3)});
    MatrixXd holes = random_matrix(generator, m, 6);
    holes.col(1).setZero();
    holes.col(4).setZero();
    out.push_back({"zero columns", holes, std::min<Index>(m, 4)});
    out.push_back({"identical rows", MatrixXd::Ones(m, 1) * random_matrix(generator, 1, 6), 1});
    out.push_back({"nothing", MatrixXd::Zero(m, 6), 0});
    out.push_back({"one column", random_matrix(generator, m, 1), 1});
    out.push_back({"no column", MatrixXd(m, 0), 0});
  }
  return out;
}

MatrixXd whole(const NullSpaceProjection& projection, Index m) {
  MatrixXd Qt = MatrixXd::Identity(m, m);
  projection.apply_left(Qt);
  return Qt;
}

TEST(NullSpaceProjection, IsAnOrthogonalChangeOfRows) {
  Generator generator(1);
  for (const Case& c : cases(generator)) {
    const Index m = c.D.rows();
    const MatrixXd Qt = whole(NullSpaceProjection(c.D), m);
    EXPECT_LE((Qt * Qt.transpose() - MatrixXd::Identity(m, m)).cwiseAbs().maxCoeff(), 1e-13) << c.name;
  }
}

TEST(NullSpaceProjection, FindsTheRankAndPutsAllOfDIntoAsManyLastRows) {
  Generator generator(2);
  for (const double size : {1.0, 1e3}) {
    for (const Case& c : cases(generator)) {
      const NullSpaceProjection projection(size * c.D);
      EXPECT_EQ(projection.rank(), c.rank) << c.name << ", " << c.D.rows() << " rows";
      MatrixXd moved = size * c.D;
      projection.apply_left(moved);
      const MatrixXd above = moved.topRows(moved.rows() - projection.rank());
      if (above.size() > 0) {
        EXPECT_LE(above.cwiseAbs().maxCoeff(), 1e-12 * size) << c.name << ", " << c.D.rows() << " rows";
      }
    }
  }
}

TEST(NullSpaceProjection, NeverTouchesRowsOfZeros) {
  Generator generator(3);
  for (const Case& c : cases(generator)) {
    const Index m = c.D.rows();
    const MatrixXd Qt = whole(NullSpaceProjection(c.D), m);
    for (Index row = 0; row < m; ++row) {
      if (c.D.row(row).isZero(0.0)) {
        // Such a row appears once in the result, unchanged.
        EXPECT_EQ(Qt.col(row).cwiseAbs().sum(), 1.0) << c.name;
        EXPECT_EQ(Qt.col(row).maxCoeff(), 1.0) << c.name;
      }
    }
  }
}

TEST(NullSpaceProjection, ActsOnColumnsAsOnRows) {
  Generator generator(4);
  for (const Case& c : cases(generator)) {
    const Index m = c.D.rows();
    const NullSpaceProjection projection(c.D);
    const MatrixXd X = random_matrix(generator, 5, m);
    MatrixXd right = X;
    projection.apply_right(right);
    MatrixXd left = X.transpose();
    projection.apply_left(left);
    EXPECT_LE((right - left.transpose()).cwiseAbs().maxCoeff(), 1e-13) << c.name;
  }
}

TEST(NullSpaceProjection, ActsOnBothSidesOfASymmetricMatrixAtOnce) {
  Generator generator(8);
  for (const Case& c : cases(generator)) {
    const Index m = c.D.rows();
    const NullSpaceProjection projection(c.D);
    const MatrixXd A = random_matrix(generator, m, m);
    const MatrixXd S = A + A.transpose();
    MatrixXd expected = S;
    projection.apply_left(expected);
    projection.apply_right(expected);
    MatrixXd found = S;
    projection.apply_both(found);
    const MatrixXd lower = (found - expected).triangularView<Eigen::Lower>();
    EXPECT_LE(lower.cwiseAbs().maxCoeff(), 1e-12) << c.name << ", " << m << " rows";
  }
}

TEST(NullSpaceProjection, LeavesDirectionsAloneThatMoveNoPixelByAThousandthOfItsNoise) {
  Generator generator(5);
  const MatrixXd U =
      random_matrix(generator, 20, 2).householderQr().householderQ() * MatrixXd::Identity(20, 2);
  for (const auto& [strength, rank] : std::vector<std::pair<double, Index>>{
           {2.0 * kWeakDirection, 2}, {0.5 * kWeakDirection, 1}, {0.0, 1}}) {
    MatrixXd D = U;
    D.col(1) *= strength;
    EXPECT_EQ(NullSpaceProjection(D).rank(), rank) << strength;
  }
  // Two weak parameters that push the same way can be strong together.
  const MatrixXd same = 0.8 * kWeakDirection * U.col(0) * Eigen::RowVector2d(1.0, 1.0);
  EXPECT_EQ(NullSpaceProjection(same).rank(), 1);
}

TEST(NullSpaceProjection, SilencesWhatIsStrongInDegenerateStereoGeometry) {
  Generator generator(6);
  for (const testing::StereoProblem& problem : testing::degenerate_problems(generator)) {
    const MatrixXd D = problem.z.sigma.cwiseInverse().asDiagonal() * problem.z.D * problem.C;
    const NullSpaceProjection projection(D);
    MatrixXd moved = D;
    projection.apply_left(moved);
    const MatrixXd left_over = moved.topRows(D.rows() - projection.rank());
    const MatrixXd strong = strong_directions(D);
    EXPECT_EQ(strong.cols(), projection.rank()) << problem.name;
    if (left_over.size() > 0) {
      const double largest = left_over.jacobiSvd().singularValues()(0);
      EXPECT_LE(largest, kWeakDirection) << problem.name;
    }
  }
}

TEST(StrongDirections, SpanTheColumnSpaceWithoutTheWeak) {
  Generator generator(7);
  for (const Case& c : cases(generator)) {
    const MatrixXd strong = strong_directions(c.D);
    ASSERT_EQ(strong.cols(), c.rank) << c.name;
    if (c.rank == 0) {
      continue;
    }
    // D is within their span.
    const MatrixXd rest = c.D - strong * strong.householderQr().solve(c.D);
    EXPECT_LE(rest.cwiseAbs().maxCoeff(), 1e-12) << c.name;
    EXPECT_EQ(Eigen::FullPivLU<MatrixXd>(strong).rank(), c.rank) << c.name;
  }
}

}  // namespace
}  // namespace limber
