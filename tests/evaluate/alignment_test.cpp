// SPDX-License-Identifier: MIT
#include "limber/evaluate/alignment.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "evaluate/square.hpp"
#include "random_geometry.hpp"

namespace limber {
namespace {

using testing::Generator;
using testing::matched;

double sum_of_squares(const std::vector<MatchedPose>& poses, const Alignment& alignment) {
  double sum = 0.0;
  for (const MatchedPose& pose : poses) {
    sum += ((alignment * pose.estimate).p - pose.truth.p).squaredNorm();
  }
  return sum;
}

// The truth is s R p + t of the estimate, plus noise.
std::vector<MatchedPose> moved_by(Generator& generator, const Pose& T, double scale, double noise) {
  std::vector<MatchedPose> poses;
  for (std::size_t i = 0; i < 30; ++i) {
    const Pose estimate = testing::random_pose(generator, 5.0);
    const Eigen::Vector3d p = scale * (T.R * estimate.p) + T.p + testing::random_vector(generator, noise);
    poses.push_back(matched(i, estimate, {T.R * estimate.R, p}));
  }
  return poses;
}

TEST(Align, TheSquareNeedsADoublingAQuarterTurnAndAShift) {
  const Alignment sim3 = align(testing::square(), AlignmentKind::kSim3);
  ASSERT_EQ(sim3.status, AlignmentStatus::kAligned);
  EXPECT_NEAR(sim3.scale, 2.0, 1e-14);
  EXPECT_TRUE(sim3.T_true_est.R.isApprox(testing::yaw_rotation(90.0), 1e-14));
  EXPECT_TRUE(sim3.T_true_est.p.isApprox(Eigen::Vector3d(10.0, 0.0, 5.0), 1e-14));
}

TEST(Align, Se3KeepsTheSizeAndPutsTheCentresTogether) {
  const Alignment se3 = align(testing::square(), AlignmentKind::kSe3);
  ASSERT_EQ(se3.status, AlignmentStatus::kAligned);
  EXPECT_EQ(se3.scale, 1.0);
  EXPECT_TRUE(se3.T_true_est.R.isApprox(testing::yaw_rotation(90.0), 1e-14));
  // Centre (0.5, 0.5, 0) turns to (-0.5, 0.5, 0); the truth's centre is (9, 1, 5).
  EXPECT_TRUE(se3.T_true_est.p.isApprox(Eigen::Vector3d(9.5, 0.5, 5.0), 1e-14));
}

TEST(Align, FirstPosesMeetInPositionAndYaw) {
  auto poses = testing::square();
  const Alignment level = align(poses, AlignmentKind::kFirstPose);
  EXPECT_TRUE(level.T_true_est.R.isApprox(testing::yaw_rotation(90.0), 1e-14));
  EXPECT_TRUE((level * poses[0].estimate).p.isApprox(poses[0].truth.p, 1e-14));

  // A tilt of the first estimate is an error, and must not turn the world over.
  poses[0].estimate.R = so3_exp({0.2, 0.0, 0.0});
  const Alignment tilted = align(poses, AlignmentKind::kFirstPose);
  EXPECT_TRUE(tilted.T_true_est.R.isApprox(testing::yaw_rotation(90.0), 1e-14));
  EXPECT_TRUE((tilted * poses[0].estimate).p.isApprox(poses[0].truth.p, 1e-14));
}

TEST(Align, RecoversAnySimilarity) {
  Generator generator(1);
  for (int i = 0; i < 50; ++i) {
    const Pose T = testing::random_pose(generator, 100.0);
    const double scale = testing::random_scalar(generator, 0.01, 50.0);
    const Alignment sim3 = align(moved_by(generator, T, scale, 0.0), AlignmentKind::kSim3);
    ASSERT_EQ(sim3.status, AlignmentStatus::kAligned);
    EXPECT_NEAR(sim3.scale / scale, 1.0, 1e-12);
    EXPECT_LT((sim3.T_true_est.R - T.R).norm(), 1e-12);
    EXPECT_LT((sim3.T_true_est.p - T.p).norm(), 1e-11);
  }
}

TEST(Align, NoSmallChangeFitsBetter) {
  Generator generator(2);
  const auto poses = moved_by(generator, testing::random_pose(generator, 10.0), 1.3, 0.5);
  for (const AlignmentKind kind : {AlignmentKind::kSe3, AlignmentKind::kSim3}) {
    const Alignment best = align(poses, kind);
    const double least = sum_of_squares(poses, best);
    for (int i = 0; i < 200; ++i) {
      Alignment other = best;
      other.T_true_est.R = best.T_true_est.R * so3_exp(testing::random_vector(generator, 1e-3));
      other.T_true_est.p += testing::random_vector(generator, 1e-3);
      other.scale *=
          kind == AlignmentKind::kSim3 ? 1.0 + testing::random_scalar(generator, -1e-3, 1e-3) : 1.0;
      EXPECT_GT(sum_of_squares(poses, other), least);
    }
  }
}

TEST(Align, NeverMirrors) {
  Generator generator(3);
  auto poses = moved_by(generator, Pose{}, 1.0, 0.0);
  for (MatchedPose& pose : poses) {
    pose.truth.p.x() = -pose.truth.p.x();
  }
  const Alignment se3 = align(poses, AlignmentKind::kSe3);
  ASSERT_EQ(se3.status, AlignmentStatus::kAligned);
  EXPECT_NEAR(se3.T_true_est.R.determinant(), 1.0, 1e-12);
}

TEST(Align, SaysWhyItIsNotDetermined) {
  const Pose here{Eigen::Matrix3d::Identity(), {100.1, 200.3, -7.7}};
  std::vector<MatchedPose> two = {matched(0, {}, here), matched(1, here, {})};
  std::vector<MatchedPose> still, line, truth_still;
  const Eigen::Vector3d direction(0.3, -0.2, 0.11);
  for (std::size_t i = 0; i < 20; ++i) {
    const Pose on_line{Eigen::Matrix3d::Identity(), here.p + static_cast<double>(i) * direction};
    still.push_back(matched(i, here, on_line));
    truth_still.push_back(matched(i, on_line, here));
    line.push_back(matched(i, on_line, on_line));
  }
  for (const AlignmentKind kind : {AlignmentKind::kSe3, AlignmentKind::kSim3}) {
    EXPECT_EQ(align({}, kind).status, AlignmentStatus::kTooFewPoses);
    EXPECT_EQ(align(two, kind).status, AlignmentStatus::kTooFewPoses);
    EXPECT_EQ(align(still, kind).status, AlignmentStatus::kNoMotion);
    EXPECT_EQ(align(truth_still, kind).status, AlignmentStatus::kNoMotion);
    EXPECT_EQ(align(line, kind).status, AlignmentStatus::kStraightLine);
  }
  EXPECT_EQ(align({}, AlignmentKind::kFirstPose).status, AlignmentStatus::kTooFewPoses);
  EXPECT_EQ(align(two, AlignmentKind::kFirstPose).status, AlignmentStatus::kAligned);
  EXPECT_EQ(align({}, AlignmentKind::kNone).status, AlignmentStatus::kAligned);
}

TEST(Align, ADriveThatIsAlmostStraightIsStillAligned) {
  std::vector<MatchedPose> poses;
  for (std::size_t i = 0; i < 20; ++i) {
    const auto x = static_cast<double>(i);
    const Eigen::Vector3d p(x, 1e-3 * std::sin(x), 0.0);
    const Pose truth{Eigen::Matrix3d::Identity(), testing::yaw_rotation(30.0) * p};
    poses.push_back(matched(i, {Eigen::Matrix3d::Identity(), p}, truth));
  }
  const Alignment se3 = align(poses, AlignmentKind::kSe3);
  ASSERT_EQ(se3.status, AlignmentStatus::kAligned);
  EXPECT_LT((se3.T_true_est.R - testing::yaw_rotation(30.0)).norm(), 1e-8);
}

}  // namespace
}  // namespace limber
