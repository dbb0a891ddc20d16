// SPDX-License-Identifier: MIT
#include "limber/update/frame_innovation.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "check_covariance.hpp"
#include "limber/core/dense.hpp"
#include "stereo_problem.hpp"

namespace limber {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::Generator;
using testing::StereoProblem;
using testing::Updated;
using testing::updated;

constexpr double kExact = 1e-9;
constexpr Index kEpipolar = 5;  // what the right pixel says of the rig, whatever the depth: all but the scale

/// Half of the points Cartesian, half with an anchor in common; `seen_by_both` of them by both cameras.
StereoProblem random_problem(Generator& generator, int points, double seen_by_both = 1.0) {
  auto seen = testing::random_points(generator, points, 2.0, 60.0);
  for (testing::SeenPoint& point : seen) {
    point.in_cam1 = testing::random_scalar(generator, 0.0, 1.0) < seen_by_both;
  }
  StereoProblem out =
      testing::make_problem(generator, std::to_string(points) + " points", testing::stereo_rig(2.0), seen);
  out.z.sigma = (0.3 * testing::random_normal(generator, out.z.rows())).cwiseAbs().array() + 0.2;
  return out;
}

std::vector<ParameterErrorModel> treatments(const StereoProblem& problem) {
  const MatrixXd white = multiply(problem.C, transposed(problem.C));
  return {{}, problem.constrained(), {{}, white}, {problem.C.leftCols<3>(), white}};
}

Innovation compressed_rows(const StereoProblem& problem) {
  return compressed(form_frame_innovation(problem.P, problem.z));
}

/// Row for row, nothing turned.
Updated slowly(const StereoProblem& problem, const ParameterErrorModel& how) {
  Covariance P = problem.P;
  Updated out;
  out.report = update(P, form_innovation(P, problem.z), how);
  out.P = P.dense();
  return out;
}

/// Same correction, covariance, NIS and degrees of freedom.
void expect_same_update(const StereoProblem& problem) {
  const VectorXd sigma = testing::prior_sigma(problem.P);
  for (const ParameterErrorModel& how : treatments(problem)) {
    const Updated slow = slowly(problem, how), fast = updated(problem, how);
    ASSERT_EQ(fast.report.status, slow.report.status) << problem.name;
    EXPECT_EQ(fast.report.rank, slow.report.rank) << problem.name;
    EXPECT_EQ(fast.report.dof, slow.report.dof) << problem.name;
    EXPECT_NEAR(fast.report.nis, slow.report.nis, kExact * slow.report.nis) << problem.name;
    EXPECT_LE(testing::relative_difference(fast.report.dx, slow.report.dx, sigma), kExact) << problem.name;
    EXPECT_LE(testing::relative_difference(fast.P, slow.P, sigma), kExact) << problem.name;
  }
}

TEST(FrameInnovation, LeavesTheUpdateAsItIs) {
  Generator generator(1);
  for (const int points : {1, 2, 3, 4, 6, 9, 24, 45, 90}) {
    for (const double seen_by_both : {1.0, 0.9, 0.4, 0.0}) {
      expect_same_update(random_problem(generator, points, seen_by_both));
    }
  }
}

TEST(FrameInnovation, LeavesThreeRowsAPointAndSetsTheEpipolarGeometryApart) {
  Generator generator(2);
  const Innovation rows = compressed_rows(random_problem(generator, 60));
  EXPECT_EQ(rows.r.size(), 60 * 3);
  EXPECT_EQ(rows.S.rows(), rows.r.size());
  EXPECT_EQ(rows.stateless.residual.size(), kEpipolar);
  EXPECT_EQ(rows.noise.rows, 60 - kEpipolar);
}

TEST(FrameInnovation, LooksForNoMoreDirectionsThanThereAre) {
  Generator generator(3);
  StereoProblem problem = random_problem(generator, 60);
  problem.z.D.col(1).setZero();
  EXPECT_EQ(compressed_rows(problem).stateless.residual.size(), kEpipolar - 1);
  expect_same_update(problem);
}

TEST(FrameInnovation, CopesWithoutParameters) {
  Generator generator(4);
  StereoProblem problem = random_problem(generator, 60);
  problem.z.D.resize(0, 0);
  EXPECT_EQ(compressed_rows(problem).noise.rows, 60);
  const Updated slow = slowly(problem, {}), fast = updated(problem, {});
  const VectorXd sigma = testing::prior_sigma(problem.P);
  EXPECT_LE(testing::relative_difference(fast.report.dx, slow.report.dx, sigma), kExact);
  EXPECT_LE(testing::relative_difference(fast.P, slow.P, sigma), kExact);
}

TEST(FrameInnovation, LeavesFewRowsOfWhatSeesParametersThatAreStates) {
  Generator generator(7);
  StereoProblem problem = random_problem(generator, 60);
  testing::make_theta_a_state(problem);
  const Innovation rows = compressed_rows(problem);
  EXPECT_EQ(rows.r.size(), 60 * 3 + kEpipolar);
  EXPECT_EQ(rows.stateless.residual.size(), 0);
  EXPECT_EQ(rows.noise.rows, 60 - kEpipolar);
  expect_same_update(problem);
}

TEST(FrameInnovation, KeepsAFourthRowThatSeesMoreThanOthersDo) {
  Generator generator(8);
  StereoProblem problem = random_problem(generator, 30);
  problem.z.H.blocks.push_back({8, 6, MatrixXd::Ones(2, 3)});  // no function of where the point stands
  const Innovation rows = compressed_rows(problem);
  EXPECT_EQ(rows.r.size(), 30 * 3 + 1);
  EXPECT_EQ(rows.noise.rows, 29 - kEpipolar);
  expect_same_update(problem);
}

TEST(FrameInnovation, CountsWhatWasTakenOutBefore) {
  Generator generator(5);
  StereoProblem problem = random_problem(generator, 60);
  problem.z.noise = {7, 5.5};
  expect_same_update(problem);
}

TEST(FrameInnovation, DoesNothingWhereThereIsNothingToGain) {
  Generator generator(6);
  const StereoProblem problem = random_problem(generator, 60, 0.0);
  const Innovation rows = compressed_rows(problem), as_they_are = form_innovation(problem.P, problem.z);
  EXPECT_EQ(rows.r, as_they_are.r);
  EXPECT_EQ(rows.S, as_they_are.S);
  EXPECT_EQ(rows.noise.rows, 0);
}

TEST(FrameInnovation, WithoutSomePointsIsThatOfTheOthers) {
  Generator generator(9);
  for (const bool theta_is_a_state : {false, true}) {
    for (const double seen_by_both : {1.0, 0.6}) {
      StereoProblem problem = random_problem(generator, 40, seen_by_both);
      if (theta_is_a_state) {
        testing::make_theta_a_state(problem);
      }
      std::vector<bool> kept(problem.z.groups.size());
      for (std::size_t g = 0; g < kept.size(); ++g) {
        kept[g] = g % 3 != 1;
      }
      StereoProblem rest = problem;
      rest.z = problem.z.subset(kept);
      const VectorXd sigma = testing::prior_sigma(problem.P);
      for (const ParameterErrorModel& how : treatments(problem)) {
        Covariance P = problem.P;
        const UpdateReport fast = update(P, compressed(form_frame_innovation(P, problem.z), kept), how);
        const Updated slow = slowly(rest, how);
        EXPECT_EQ(fast.dof, slow.report.dof);
        EXPECT_NEAR(fast.nis, slow.report.nis, kExact * slow.report.nis);
        EXPECT_LE(testing::relative_difference(fast.dx, slow.report.dx, sigma), kExact);
        EXPECT_LE(testing::relative_difference(P.dense(), slow.P, sigma), kExact);
      }
    }
  }
}

TEST(FrameInnovation, OfNoPointUpdatesNothing) {
  Generator generator(10);
  const StereoProblem problem = random_problem(generator, 10);
  Covariance P = problem.P;
  const std::vector<bool> none(problem.z.groups.size(), false);
  EXPECT_EQ(update(P, compressed(form_frame_innovation(P, problem.z), none), problem.constrained()).status,
            UpdateStatus::kEmpty);
  EXPECT_EQ(update(P, LinearMeasurement{}, {}).status, UpdateStatus::kEmpty);
}

}  // namespace
}  // namespace limber
