// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <Eigen/SVD>

#include "check_covariance.hpp"
#include "limber/core/factors.hpp"
#include "limber/update/constraint.hpp"
#include "limber/update/update.hpp"
#include "stereo_problem.hpp"

namespace limber {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::Generator;
using testing::prior_sigma;
using testing::relative_difference;
using testing::StereoProblem;
using testing::Updated;
using testing::updated;

constexpr double kNear = 1e-9;

std::vector<StereoProblem> ordinary_problems(Generator& generator, int count) {
  std::vector<StereoProblem> out;
  for (int k = 0; k < count; ++k) {
    const BodyFrame body = k % 3 == 0   ? BodyFrame::kImu
                           : k % 3 == 1 ? BodyFrame::kCam0
                                        : BodyFrame::kMiddleOfBaseline;
    auto points = testing::random_points(generator, 4 + k % 20, 1.0, k % 2 == 0 ? 20.0 : 200.0);
    for (testing::SeenPoint& point : points) {
      point.in_cam1 = testing::random_scalar(generator, 0.0, 1.0) < 0.85;
    }
    out.push_back(testing::make_problem(generator, "problem " + std::to_string(k),
                                        testing::stereo_rig(k % 4 < 2 ? 0.12 : 2.0, body), points));
  }
  return out;
}

/// Condition of DᵀS⁻¹D with D's columns scaled.
double condition(const StereoProblem& problem) {
  const MatrixXd S = congruence(problem.H(), problem.P.dense()) + problem.R();
  const MatrixXd DC = multiply(problem.z.D, problem.C);
  const MatrixXd M = multiply(transposed(DC), Cholesky(S).solve(DC));
  const VectorXd eigenvalues = symmetric_eigen(M).values;
  return eigenvalues(0) > 0.0 ? eigenvalues(5) / eigenvalues(0) : std::numeric_limits<double>::infinity();
}

/// Smallest eigenvalue of A in units of the prior: of L⁻¹ A L⁻ᵀ, prior = L Lᵀ.
double smallest_eigenvalue(const MatrixXd& A, const MatrixXd& prior) {
  const Cholesky cholesky(prior);
  MatrixXd white = A;
  solve_lower(cholesky.factor(), white);
  solve_lower_from_right(transposed(cholesky.factor()), white);
  return symmetric_eigen(white).values(0);
}

TEST(ConstrainedUpdate, NullSpaceFormIsTheGainFormWhereTheConstraintsAreWellConditioned) {
  Generator generator(1);
  int compared = 0;
  for (const StereoProblem& problem : ordinary_problems(generator, 300)) {
    if (condition(problem) > 1e6) {
      continue;
    }
    ++compared;
    const Updated null_space = updated(problem, problem.constrained());
    Covariance P = problem.P;
    const UpdateReport gain_form = update_gain_form(P, problem.z, problem.constrained());
    ASSERT_EQ(null_space.report.status, UpdateStatus::kUpdated) << problem.name;
    ASSERT_EQ(gain_form.status, UpdateStatus::kUpdated) << problem.name;
    EXPECT_EQ(null_space.report.rank, 6) << problem.name;
    EXPECT_EQ(null_space.report.dof, gain_form.dof) << problem.name;
    const VectorXd sigma = prior_sigma(problem.P);
    EXPECT_LE(relative_difference(null_space.report.dx, gain_form.dx, sigma), kNear) << problem.name;
    EXPECT_LE(relative_difference(null_space.P, P.dense(), sigma), kNear) << problem.name;
    EXPECT_NEAR(null_space.report.nis, gain_form.nis, kNear * gain_form.nis) << problem.name;
  }
  EXPECT_GE(compared, 200);
}

TEST(ConstrainedUpdate, GainFormRefusesDependentConstraintsAndLeavesTheCovarianceAlone) {
  Generator generator(2);
  for (const StereoProblem& problem : testing::degenerate_problems(generator)) {
    if (!problem.z.D.col(0).isZero(0.0)) {
      continue;
    }
    Covariance P = problem.P;
    const UpdateReport report = update_gain_form(P, problem.z, problem.constrained());
    EXPECT_EQ(report.status, UpdateStatus::kSingularInnovation) << problem.name;
    EXPECT_EQ(P.dense(), problem.P.dense()) << problem.name;
    EXPECT_TRUE(report.dx.isZero(0.0)) << problem.name;
  }
}

TEST(ConstrainedUpdate, GainIsBlindToTheConstrainedDirectionsWhateverTheGeometry) {
  Generator generator(3);
  std::vector<StereoProblem> problems = testing::degenerate_problems(generator);
  for (StereoProblem& problem : ordinary_problems(generator, 30)) {
    problems.push_back(std::move(problem));
  }
  for (const StereoProblem& problem : problems) {
    const MatrixXd L = testing::gain(problem, problem.constrained());
    const MatrixXd K = testing::gain(problem, {});
    const VectorXd weight = prior_sigma(problem.P).cwiseInverse();
    const MatrixXd DC = multiply(problem.z.D, problem.C);
    const double unconstrained = std::max(1.0, MatrixXd(weight.asDiagonal() * K * DC).cwiseAbs().maxCoeff());
    const MatrixXd heard = weight.asDiagonal() * L * DC;
    const RightSingular svd = right_singular(heard);
    for (Index k = 0; k < svd.values.size(); ++k) {
      if (svd.values(k) <= kNear * unconstrained) {
        continue;  // silenced
      }
      // What is heard is too weak to matter: a plausible error moves no pixel by a thousandth of its noise.
      const VectorXd moved = problem.z.sigma.cwiseInverse().asDiagonal() * (DC * svd.V.col(k));
      EXPECT_LE(moved.norm(), kWeakDirection) << problem.name;
      EXPECT_LE((heard * svd.V.col(k)).cwiseAbs().maxCoeff(), kWeakDirection) << problem.name;
    }
  }
}

TEST(ConstrainedUpdate, CovarianceStaysPositiveDefiniteWhateverTheGeometry) {
  Generator generator(4);
  for (const StereoProblem& problem : testing::degenerate_problems(generator)) {
    const Updated result = updated(problem, problem.constrained());
    EXPECT_EQ(result.P, result.P.transpose()) << problem.name;
    EXPECT_TRUE(Cholesky(result.P).succeeded()) << problem.name;
    EXPECT_GT(smallest_eigenvalue(result.P, problem.P.dense()), 0.0) << problem.name;
  }
}

TEST(ConstrainedUpdate, NeverShrinksTheCovarianceBelowTheEkfsNorGrowsItAboveThePrior) {
  Generator generator(5);
  std::vector<StereoProblem> problems = testing::degenerate_problems(generator);
  for (StereoProblem& problem : ordinary_problems(generator, 30)) {
    problems.push_back(std::move(problem));
  }
  for (const StereoProblem& problem : problems) {
    const MatrixXd prior = problem.P.dense();
    const MatrixXd ekf = updated(problem, {}).P;
    const MatrixXd constrained = updated(problem, problem.constrained()).P;
    EXPECT_GE(smallest_eigenvalue(constrained - ekf, prior), -kNear) << problem.name;
    EXPECT_GE(smallest_eigenvalue(prior - constrained, prior), -kNear) << problem.name;
  }
}

TEST(ConstrainedUpdate, EachConstraintMoreCostsInformation) {
  Generator generator(6);
  for (const StereoProblem& problem : ordinary_problems(generator, 20)) {
    MatrixXd previous = updated(problem, {}).P;
    for (Index k = 1; k <= 6; ++k) {
      const MatrixXd P = updated(problem, {problem.C.leftCols(k), {}}).P;
      EXPECT_GE(smallest_eigenvalue(P - previous, problem.P.dense()), -kNear) << problem.name << ", " << k;
      EXPECT_GT(P.trace(), previous.trace()) << problem.name << ", " << k;
      previous = P;
    }
  }
}

TEST(ConstrainedUpdate, ACalibrationErrorInAConstrainedDirectionMovesNothing) {
  Generator generator(7);
  for (StereoProblem problem : ordinary_problems(generator, 50)) {
    const UpdateReport before = updated(problem, problem.constrained()).report;
    const UpdateReport ekf_before = updated(problem, {}).report;
    problem.z.residual += problem.z.D * problem.C * (100.0 * testing::random_normal(generator, 6));
    const UpdateReport after = updated(problem, problem.constrained()).report;
    const UpdateReport ekf_after = updated(problem, {}).report;
    const VectorXd weight = prior_sigma(problem.P).cwiseInverse();
    const double moved_ekf = (ekf_after.dx - ekf_before.dx).cwiseProduct(weight).cwiseAbs().maxCoeff();
    EXPECT_LE((after.dx - before.dx).cwiseProduct(weight).cwiseAbs().maxCoeff(), kNear * moved_ekf)
        << problem.name;
    EXPECT_GT(moved_ekf, 1.0) << problem.name;
  }
}

/// The problem without its right-camera rows. Its first rows of each point are the left camera's.
StereoProblem left_only(const StereoProblem& problem) {
  StereoProblem out = problem;
  std::vector<Index> rows;
  out.z.H.blocks.clear();
  out.z.groups.clear();
  for (const RowGroup& group : problem.z.groups) {
    const Index to = static_cast<Index>(rows.size());
    out.z.groups.push_back({to, 2});
    rows.push_back(group.row);
    rows.push_back(group.row + 1);
    for (SparseJacobian::Block block : problem.z.H.blocks) {
      if (block.row == group.row) {
        block.row = to;
        out.z.H.blocks.push_back(block);
      }
    }
  }
  out.z.residual = problem.z.residual(rows);
  out.z.sigma = problem.z.sigma(rows);
  out.z.D = problem.z.D(rows, Eigen::all);
  return out;
}

TEST(ConstrainedUpdate, UpToThreeStereoPointsTheRightCameraSaysNothing) {
  Generator generator(8);
  for (int k = 0; k < 60; ++k) {
    const int count = 1 + k % 3;
    const StereoProblem problem =
        testing::make_problem(generator, std::to_string(count) + " points", testing::stereo_rig(0.5),
                              testing::random_points(generator, count, 2.0, 20.0));
    const Updated both = updated(problem, problem.constrained());
    const Updated left = updated(left_only(problem), {});
    EXPECT_EQ(both.report.rank, 2 * count);
    EXPECT_EQ(both.report.dof, 2 * count);
    const VectorXd sigma = prior_sigma(problem.P);
    EXPECT_LE(relative_difference(both.report.dx, left.report.dx, sigma), kNear) << problem.name;
    EXPECT_LE(relative_difference(both.P, left.P, sigma), kNear) << problem.name;
  }
}

TEST(ConstrainedUpdate, FromFourStereoPointsOnTheRightCameraSaysSomething) {
  Generator generator(9);
  const StereoProblem problem = testing::make_problem(generator, "4 points", testing::stereo_rig(0.5),
                                                      testing::random_points(generator, 4, 2.0, 20.0));
  const Updated both = updated(problem, problem.constrained());
  const Updated left = updated(left_only(problem), {});
  EXPECT_EQ(both.report.dof, 16 - 6);
  EXPECT_LT(both.P.trace(), left.P.trace());
}

TEST(ConstrainedUpdate, RankIsThatOfWhatTheGeometrySees) {
  Generator generator(10);
  const auto rank_at = [&](double distance, int count) {
    const StereoProblem problem =
        testing::make_problem(generator, "", testing::stereo_rig(0.12),
                              testing::random_points(generator, count, distance, distance * 1.5));
    return updated(problem, problem.constrained()).report.rank;
  };
  EXPECT_EQ(rank_at(5.0, 20), 6);
  EXPECT_EQ(rank_at(1e7, 20), 3);  // turns move the pixels of far points, shifts do not
  EXPECT_EQ(rank_at(5.0, 1), 2);
  EXPECT_EQ(rank_at(5.0, 2), 4);
}

}  // namespace
}  // namespace limber
