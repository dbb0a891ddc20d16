// SPDX-License-Identifier: MIT
#include "limber/update/compress.hpp"

#include <gtest/gtest.h>

#include <algorithm>

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

std::vector<ParameterTreatment> treatments(const StereoProblem& problem) {
  const MatrixXd white = problem.C * problem.C.transpose();
  return {{}, problem.constrained(), {{}, white}, {problem.C.leftCols<3>(), white}};
}

/// Same correction, covariance, NIS and degrees of freedom.
void expect_same_update(const StereoProblem& problem, const StereoProblem& compressed) {
  const VectorXd sigma = testing::prior_sigma(problem.P);
  for (const ParameterTreatment& how : treatments(problem)) {
    const Updated slow = updated(problem, how), fast = updated(compressed, how);
    ASSERT_EQ(fast.report.status, slow.report.status) << problem.name;
    EXPECT_EQ(fast.report.rank, slow.report.rank) << problem.name;
    EXPECT_EQ(fast.report.dof, slow.report.dof) << problem.name;
    EXPECT_NEAR(fast.report.nis, slow.report.nis, kExact * slow.report.nis) << problem.name;
    EXPECT_LE(testing::relative_difference(fast.report.dx, slow.report.dx, sigma), kExact) << problem.name;
    EXPECT_LE(testing::relative_difference(fast.P, slow.P, sigma), kExact) << problem.name;
  }
}

TEST(Compress, LeavesTheUpdateAsItIs) {
  Generator generator(1);
  for (const int points : {40, 45, 60, 61, 90}) {
    for (const double seen_by_both : {1.0, 0.9, 0.8}) {
      const StereoProblem problem = random_problem(generator, points, seen_by_both);
      StereoProblem small = problem;
      small.z = compressed(problem.z);
      EXPECT_LT(small.z.rows(), problem.z.rows()) << problem.name;
      EXPECT_TRUE(small.z.groups.empty());
      expect_same_update(problem, small);
    }
  }
}

TEST(Compress, LeavesThreeRowsAPointAndWhatTheEpipolarGeometrySaysOfTheRig) {
  Generator generator(2);
  const StereoProblem problem = random_problem(generator, 60);
  // The anchored half stays as it is: its anchor is neither a point's own nor shared by more than half.
  const LinearMeasurement z = compressed(problem.z);
  EXPECT_EQ(z.rows(), 30 * 3 + 30 * 4 + kEpipolar);
  EXPECT_EQ(z.noise.rows, 30 - kEpipolar);
  EXPECT_EQ(z.sigma, VectorXd::Ones(z.rows()));
}

TEST(Compress, LooksForNoMoreDirectionsThanThereAre) {
  Generator generator(3);
  StereoProblem problem = random_problem(generator, 60);
  problem.z.D.col(1).setZero();
  StereoProblem small = problem;
  small.z = compressed(problem.z);
  EXPECT_EQ(small.z.noise.rows, 30 - (kEpipolar - 1));
  expect_same_update(problem, small);
}

TEST(Compress, CopesWithParametersThatAreStatesOrAreNotThere) {
  Generator generator(4);
  StereoProblem problem = random_problem(generator, 60);
  problem.z.D.resize(0, 0);
  const LinearMeasurement z = compressed(problem.z);
  EXPECT_EQ(z.noise.rows, 30);
  Covariance slow = problem.P, fast = problem.P;
  const UpdateReport expected = update(slow, problem.z, {}), report = update(fast, z, {});
  const VectorXd sigma = testing::prior_sigma(problem.P);
  EXPECT_LE(testing::relative_difference(report.dx, expected.dx, sigma), kExact);
  EXPECT_LE(testing::relative_difference(fast.dense(), slow.dense(), sigma), kExact);
}

TEST(Compress, CountsWhatWasTakenOutBefore) {
  Generator generator(5);
  StereoProblem problem = random_problem(generator, 60);
  problem.z.noise = {7, 5.5};
  StereoProblem small = problem;
  small.z = compressed(problem.z);
  expect_same_update(problem, small);
}

TEST(Compress, DoesNothingWhereThereIsNothingToGain) {
  Generator generator(6);
  for (const StereoProblem& problem : {random_problem(generator, 24), random_problem(generator, 60, 0.0)}) {
    const LinearMeasurement z = compressed(problem.z);
    EXPECT_EQ(z.residual, problem.z.residual);
    EXPECT_EQ(z.groups.size(), problem.z.groups.size());
    EXPECT_EQ(z.noise.rows, 0);
  }
  EXPECT_EQ(compressed(LinearMeasurement{}).rows(), 0);
}

}  // namespace
}  // namespace limber
