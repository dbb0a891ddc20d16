// SPDX-License-Identifier: MIT
#include "limber/evaluate/trajectory_error.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "evaluate/square.hpp"
#include "limber/evaluate/evaluation.hpp"
#include "random_geometry.hpp"

namespace limber {
namespace {

using testing::matched;

// Positions along x: the estimate's as given, the truth's `ratio` times as far. The estimate turns by 1
// degree a pose.
std::vector<MatchedPose> along_x(const std::vector<double>& estimate, double ratio) {
  std::vector<MatchedPose> poses;
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    const Pose turned{testing::yaw_rotation(static_cast<double>(i)), {estimate[i], 0.0, 0.0}};
    poses.push_back(matched(i, turned, {Eigen::Matrix3d::Identity(), {ratio * estimate[i], 0.0, 0.0}}));
  }
  return poses;
}

std::vector<double> metre_steps(std::size_t count) {
  std::vector<double> x;
  for (std::size_t i = 0; i < count; ++i) {
    x.push_back(static_cast<double>(i));
  }
  return x;
}

TEST(AbsoluteErrors, OfTheSquareAreThoseOnPaper) {
  const TrajectoryEvaluation e = evaluate_trajectory(testing::square());
  // Squared distances of the corners: 125, 110, 75, 90.
  EXPECT_NEAR(e.none.errors->position_m.rmse, 10.0, 1e-12);
  EXPECT_NEAR(e.none.errors->position_m.sse, 400.0, 1e-10);
  EXPECT_NEAR(e.none.errors->position_m.max, std::sqrt(125.0), 1e-12);
  EXPECT_NEAR(e.none.errors->attitude_deg.rmse, 90.0, 1e-12);
  // First corners together, then 1, sqrt(2) and 1 metre apart.
  EXPECT_NEAR(e.first_pose.errors->position_m.rmse, 1.0, 1e-12);
  EXPECT_NEAR(e.first_pose.errors->position_m.mean, (2.0 + std::sqrt(2.0)) / 4.0, 1e-12);
  EXPECT_NEAR(e.first_pose.errors->attitude_deg.rmse, 0.0, 1e-12);
  // Half diagonals of 1/sqrt(2) and sqrt(2).
  EXPECT_NEAR(e.se3.errors->position_m.rmse, std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(e.se3.errors->position_m.std, 0.0, 1e-7);
  EXPECT_NEAR(e.sim3.errors->position_m.rmse, 0.0, 1e-12);
  EXPECT_NEAR(e.sim3.alignment.scale, 2.0, 1e-12);
  EXPECT_EQ(e.poses, 4u);
  EXPECT_NEAR(e.duration, 0.3, 1e-12);
  EXPECT_NEAR(e.path_length, 6.0, 1e-12);
  EXPECT_NEAR(e.path_length_estimate, 3.0, 1e-12);
}

TEST(AbsoluteErrors, RefuseAnAlignmentThatIsNotDetermined) {
  const Alignment undetermined = align({}, AlignmentKind::kSe3);
  EXPECT_THROW((void)absolute_errors(testing::square(), undetermined), std::invalid_argument);
  EXPECT_THROW((void)absolute_errors({}, Alignment{}), std::invalid_argument);
}

TEST(RelativeErrors, OfOneFrameAreTheErrorsOfTheSteps) {
  // Steps of 1 m along the heading of an estimate that turns, of 1.1 m straight on in truth: in the frame of
  // pose i the estimated step is (cos i, -sin i), i degrees.
  const auto poses = along_x(metre_steps(3), 1.1);
  const auto errors = relative_errors(poses, pairs_by_frames(poses.size(), 1));
  ASSERT_TRUE(errors);
  EXPECT_EQ(errors->position_m.count, 2u);
  EXPECT_NEAR(errors->position_m.min, 0.1, 1e-12);
  const double c = std::cos(testing::kDegree), s = std::sin(testing::kDegree);
  EXPECT_NEAR(errors->position_m.max, std::hypot(c - 1.1, s), 1e-12);
  EXPECT_NEAR(errors->attitude_deg.min, 1.0, 1e-10);
  EXPECT_NEAR(errors->attitude_deg.max, 1.0, 1e-10);
}

TEST(RelativeErrors, DoNotDependOnTheWorldsOfEstimateAndTruth) {
  testing::Generator generator(4);
  std::vector<MatchedPose> poses, moved;
  const Pose A = testing::random_pose(generator, 50.0), B = testing::random_pose(generator, 50.0);
  for (std::size_t i = 0; i < 40; ++i) {
    const Pose estimate = testing::random_pose(generator, 3.0);
    poses.push_back(matched(i, estimate, testing::random_pose(generator, 3.0)));
    moved.push_back(matched(i, A * poses[i].estimate, B * poses[i].truth));
  }
  const auto pairs = pairs_by_frames(poses.size(), 3);
  EXPECT_NEAR(relative_errors(poses, pairs)->position_m.rmse, relative_errors(moved, pairs)->position_m.rmse,
              1e-11);
  EXPECT_NEAR(relative_errors(poses, pairs)->attitude_deg.rmse,
              relative_errors(moved, pairs)->attitude_deg.rmse, 1e-10);
}

TEST(RelativeErrors, RefuseAPairThatDoesNotExist) {
  EXPECT_THROW((void)relative_errors(testing::square(), std::vector<IndexPair>{{0, 4}}),
               std::invalid_argument);
  EXPECT_FALSE(relative_errors(testing::square(), {}));
}

TEST(PairsByFrames, AreAllPairsThatFit) {
  EXPECT_EQ(pairs_by_frames(4, 3), (std::vector<IndexPair>{{0, 3}}));
  EXPECT_EQ(pairs_by_frames(4, 2), (std::vector<IndexPair>{{0, 2}, {1, 3}}));
  EXPECT_TRUE(pairs_by_frames(3, 3).empty());
  EXPECT_TRUE(pairs_by_frames(0, 1).empty());
  EXPECT_THROW((void)pairs_by_frames(3, 0), std::invalid_argument);
}

TEST(PairsByPath, ReachTheDistanceWithinTheTolerance) {
  const auto poses = along_x(metre_steps(21), 1.1);
  EXPECT_EQ(pairs_by_path(poses, 10.0, 0.05).size(), 11u);
  // Pose 11 is 9 m before the end, which a tolerance of 10 % of 10 m just lets pass.
  const auto pairs = pairs_by_path(poses, 10.0, 0.1);
  EXPECT_EQ(pairs.size(), 12u);
  EXPECT_EQ(pairs.front(), (IndexPair{0, 10}));
  EXPECT_EQ(pairs.back(), (IndexPair{11, 20}));
  EXPECT_TRUE(pairs_by_path(poses, 30.0).empty());
}

TEST(PairsByPath, MeasureTheEstimatedPath) {
  // The truth is half as far: its own distance would be reached twice as late.
  EXPECT_EQ(pairs_by_path(along_x(metre_steps(5), 0.5), 4.0, 0.0), (std::vector<IndexPair>{{0, 4}}));
}

TEST(PairsByPath, FollowTheWayBackAndForth) {
  EXPECT_EQ(pairs_by_path(along_x({0.0, 1.0, 0.0, 1.0}, 1.0), 3.0, 0.0), (std::vector<IndexPair>{{0, 3}}));
}

TEST(PairsByPath, TakeTheFirstOfEquallyGoodPoses) {
  // Standing still: the first pose there.
  EXPECT_EQ(pairs_by_path(along_x({0.0, 1.0, 1.0, 1.0, 2.0}, 1.0), 1.0, 0.0),
            (std::vector<IndexPair>{{0, 1}, {1, 4}, {2, 4}, {3, 4}}));
  // As far below as beyond: the nearer pose.
  EXPECT_EQ(pairs_by_path(along_x({0.0, 0.75, 0.75, 1.25}, 1.0), 1.0, 0.3).front(), (IndexPair{0, 1}));
}

TEST(PairsByPath, RefuseADistanceThatIsNone) {
  const auto poses = testing::square();
  EXPECT_THROW((void)pairs_by_path(poses, 0.0), std::invalid_argument);
  EXPECT_THROW((void)pairs_by_path(poses, std::nan("")), std::invalid_argument);
  EXPECT_THROW((void)pairs_by_path(poses, 1.0, -0.1), std::invalid_argument);
  EXPECT_TRUE(pairs_by_path({}, 1.0).empty());
}

TEST(DisjointPieces, FollowEachOtherAlongTheTruePath) {
  // The truth is half as far as the estimate.
  EXPECT_EQ(disjoint_pieces(along_x(metre_steps(11), 0.5), 2.0), (std::vector<IndexPair>{{0, 4}, {4, 8}}));
  EXPECT_TRUE(disjoint_pieces(along_x(metre_steps(3), 1.0), 5.0).empty());
  EXPECT_TRUE(disjoint_pieces({}, 1.0).empty());
  EXPECT_THROW((void)disjoint_pieces(testing::square(), 0.0), std::invalid_argument);
}

TEST(RelativeErrorsOf, EachPairAreThoseOfTheStatistics) {
  const auto poses = along_x(metre_steps(11), 0.5);
  const std::vector<IndexPair> pairs = {{0, 4}, {3, 9}};
  const std::vector<RelativeError> errors = relative_errors_of(poses, pairs);
  ASSERT_EQ(errors.size(), 2U);
  EXPECT_NEAR(errors[0].position_m, 2.0, 1e-12);  // 4 m instead of 2 m
  EXPECT_NEAR(errors[0].attitude_deg, 4.0, 1e-12);
  EXPECT_NEAR(errors[1].attitude_deg, 6.0, 1e-12);
  EXPECT_NEAR(relative_errors(poses, pairs)->position_m.mean,
              0.5 * (errors[0].position_m + errors[1].position_m), 1e-12);
  EXPECT_THROW((void)relative_errors_of(poses, std::vector<IndexPair>{{0, 12}}), std::invalid_argument);
}

TEST(EvaluateTrajectory, OfOnePoseKnowsOnlyWhatOnePoseTells) {
  const std::vector<MatchedPose> one = {testing::square()[0]};
  const TrajectoryEvaluation e = evaluate_trajectory(one);
  EXPECT_NEAR(e.none.errors->position_m.rmse, std::sqrt(125.0), 1e-12);
  EXPECT_NEAR(e.first_pose.errors->position_m.rmse, 0.0, 1e-12);
  EXPECT_FALSE(e.se3.errors);
  EXPECT_EQ(e.se3.alignment.status, AlignmentStatus::kTooFewPoses);
  EXPECT_FALSE(e.sim3.errors);
  EXPECT_FALSE(e.relative_1_frame);
  EXPECT_FALSE(e.relative_distance);
}

TEST(EvaluateTrajectory, OfAStraightLineLeavesTheFitsOut) {
  const TrajectoryEvaluation e = evaluate_trajectory(along_x(metre_steps(150), 1.1));
  EXPECT_TRUE(e.none.errors);
  EXPECT_FALSE(e.se3.errors);
  EXPECT_EQ(e.sim3.alignment.status, AlignmentStatus::kStraightLine);
  ASSERT_TRUE(e.relative_distance);
  // Poses 0 to 49 have one 100 m on, the next ten one 90 to 99 m on.
  EXPECT_EQ(e.relative_distance->position_m.count, 60u);
}

TEST(EvaluateTrajectory, RefusesAnEmptyList) {
  EXPECT_THROW((void)evaluate_trajectory({}), std::invalid_argument);
}

}  // namespace
}  // namespace limber
