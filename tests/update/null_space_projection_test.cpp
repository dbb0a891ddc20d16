// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/SVD>

#include "check_covariance.hpp"
#include "limber/core/factors.hpp"
#include "limber/update/constraint.hpp"
#include "limber/update/null_space_projection.hpp"
#include "limber/update/update.hpp"
#include "random_matrix.hpp"
#include "stereo_problem.hpp"

namespace limber {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using testing::Generator;
using testing::random_matrix;

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
    const MatrixXd Qt = whole(NullSpaceProjection(strong_directions(c.D)), m);
    EXPECT_LE((multiply(Qt, transposed(Qt)) - MatrixXd::Identity(m, m)).cwiseAbs().maxCoeff(), 1e-13)
        << c.name;
  }
}

TEST(NullSpaceProjection, PutsAllOfDIntoItsFirstRows) {
  Generator generator(2);
  for (const double size : {1.0, 1e3}) {
    for (const Case& c : cases(generator)) {
      const NullSpaceProjection projection(strong_directions(size * c.D));
      EXPECT_EQ(projection.rank(), c.rank) << c.name << ", " << c.D.rows() << " rows";
      MatrixXd moved = size * c.D;
      projection.apply_left(moved);
      const MatrixXd below = moved.bottomRows(moved.rows() - projection.rank());
      if (below.size() > 0) {
        EXPECT_LE(below.cwiseAbs().maxCoeff(), 1e-12 * size) << c.name << ", " << c.D.rows() << " rows";
      }
    }
  }
}

TEST(NullSpaceProjection, ActsOnColumnsAsOnRows) {
  Generator generator(4);
  for (const Case& c : cases(generator)) {
    const Index m = c.D.rows();
    const NullSpaceProjection projection(strong_directions(c.D));
    const MatrixXd X = random_matrix(generator, 150, m);
    MatrixXd right = X;
    projection.apply_right(right);
    MatrixXd left = X.transpose();
    projection.apply_left(left);
    EXPECT_LE((right - left.transpose()).cwiseAbs().maxCoeff(), 1e-13) << c.name;
  }
}

TEST(StrongDirections, LeaveAloneWhatMovesNoPixelByAThousandthOfItsNoise) {
  Generator generator(5);
  const MatrixXd U = householder_qr(random_matrix(generator, 20, 2)).Q().leftCols(2);
  for (const auto& [strength, rank] : std::vector<std::pair<double, Index>>{
           {2.0 * kWeakDirection, 2}, {0.5 * kWeakDirection, 1}, {0.0, 1}}) {
    MatrixXd D = U;
    D.col(1) *= strength;
    EXPECT_EQ(strong_directions(D).cols(), rank) << strength;
  }
  // Two weak parameters that push the same way can be strong together.
  const MatrixXd same = 0.8 * kWeakDirection * U.col(0) * Eigen::RowVector2d(1.0, 1.0);
  EXPECT_EQ(strong_directions(same).cols(), 1);
}

TEST(NullSpaceProjection, SilencesWhatIsStrongInDegenerateStereoGeometry) {
  Generator generator(6);
  for (const testing::StereoProblem& problem : testing::degenerate_problems(generator)) {
    const MatrixXd D = problem.z.sigma.cwiseInverse().asDiagonal() * multiply(problem.z.D, problem.C);
    const NullSpaceProjection projection(strong_directions(D));
    MatrixXd moved = D;
    projection.apply_left(moved);
    const MatrixXd left_over = moved.bottomRows(D.rows() - projection.rank());
    if (left_over.size() > 0) {
      EXPECT_LE(right_singular(left_over).values(0), kWeakDirection) << problem.name;
    }
  }
}

/// Rows of random size and rank, some of them stateless; S is a random covariance.
Innovation random_innovation(Generator& generator, Index rows, const MatrixXd& stateless_D) {
  Innovation out;
  out.r = testing::random_normal(generator, rows);
  out.D = random_matrix(generator, rows, 6);
  const MatrixXd A = random_matrix(generator, rows, rows);
  out.S = multiply(A, transposed(A)) + MatrixXd::Identity(rows, rows);
  out.PHt = random_matrix(generator, 9, rows);
  out.stateless = {testing::random_normal(generator, stateless_D.rows()), stateless_D};
  return out;
}

/// The rows and the stateless ones below them, as one measurement.
Innovation joined(const Innovation& parts) {
  const Index m = parts.r.size(), q = parts.stateless.residual.size();
  Innovation out;
  out.r.resize(m + q);
  out.r << parts.r, parts.stateless.residual;
  out.D.resize(m + q, parts.D.cols());
  out.D << parts.D, parts.stateless.D;
  out.S = MatrixXd::Identity(m + q, m + q);
  out.S.topLeftCorner(m, m) = parts.S;
  out.PHt = MatrixXd::Zero(parts.PHt.rows(), m + q);
  out.PHt.leftCols(m) = parts.PHt;
  out.stateless.D.resize(0, parts.D.cols());
  return out;
}

TEST(StatelessRows, SayWhatTheySayAmongTheOthers) {
  Generator generator(9);
  const MatrixXd C = testing::random_normal(generator, 6).cwiseAbs().asDiagonal();
  const auto all_but_one = [&](Index rows) {
    const MatrixXd left = random_matrix(generator, rows, 5);
    return MatrixXd(left * random_matrix(generator, 5, 6));
  };
  const MatrixXd weak =
      Eigen::VectorXd::LinSpaced(5, 1.0, 1e-4).asDiagonal() * random_matrix(generator, 5, 6);
  const MatrixXd all_weak = 1e-4 * random_matrix(generator, 3, 6);
  const MatrixXd root = random_matrix(generator, 6, 3);
  for (const MatrixXd& E : {all_but_one(5), all_but_one(2), random_matrix(generator, 6, 6), weak, all_weak,
                            MatrixXd(0, 6), MatrixXd(MatrixXd::Zero(3, 6)), random_matrix(generator, 9, 6)}) {
    for (const ParameterErrorModel& how : std::vector<ParameterErrorModel>{
             {{}, {}, C, {}},
             {C, {}, C, {}},
             {C.leftCols<3>(), {}, C.leftCols<3>(), {}},
             {{}, multiply(root, transposed(root)), C, {}},
             {{}, 1e4 * MatrixXd::Identity(6, 6), C, {}},
             {C.rightCols<2>(), multiply(root, transposed(root)), C.rightCols<2>(), {}}}) {
      const Innovation parts = random_innovation(generator, 14, E);
      MatrixXd start = MatrixXd::Identity(9, 9);
      start += 40.0 * multiply(parts.PHt, transposed(parts.PHt));
      Covariance P_parts, P_joined;
      P_parts.assign(start);
      P_joined.assign(start);
      const UpdateReport found = update(P_parts, Innovation(parts), how);
      const UpdateReport expected = update(P_joined, joined(parts), how);
      const std::string name = std::to_string(E.rows()) + " rows, " + std::to_string(how.constrained.cols()) +
                               " constrained, " + std::to_string(how.white_covariance.size()) + " white";
      ASSERT_EQ(found.status, UpdateStatus::kUpdated) << name;
      EXPECT_LE((found.dx - expected.dx).norm(), 1e-9 * expected.dx.norm()) << name;
      EXPECT_LE((P_parts.dense() - P_joined.dense()).norm(), 1e-9 * P_joined.dense().norm()) << name;
      EXPECT_EQ(found.rank, expected.rank) << name;
      EXPECT_EQ(found.dof, expected.dof) << name;
      EXPECT_NEAR(found.nis, expected.nis, 1e-9 * expected.nis) << name;
      const MatrixXd& information = expected.evidence.information;
      EXPECT_LE((found.evidence.information - information).norm(), 1e-7 * information.norm()) << name;
      EXPECT_LE((found.evidence.vector - expected.evidence.vector).norm(),
                1e-7 * expected.evidence.vector.norm())
          << name;
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
    const MatrixXd rest = c.D - multiply(strong, multiply(pseudo_inverse(strong), c.D));
    EXPECT_LE(rest.cwiseAbs().maxCoeff(), 1e-12) << c.name;
    EXPECT_EQ(pivoted_qr(strong).rank, c.rank) << c.name;
  }
}

}  // namespace
}  // namespace limber
