// SPDX-License-Identifier: MIT
#include "limber/evaluate/world_tilt.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "evaluate/square.hpp"
#include "limber/core/so3.hpp"
#include "limber/evaluate/trajectory_error.hpp"
#include "random_geometry.hpp"

namespace limber {
namespace {

using testing::Generator;
using testing::kDegree;
using testing::matched;

/// Poses whose truth stands in a world that is turned by R and shifted; the estimate's attitude is off by
/// `noise` [rad] an axis.
std::vector<MatchedPose> seen_in(const Eigen::Matrix3d& R, double noise = 0.0, std::uint64_t seed = 1) {
  Generator generator(seed);
  const Pose T_true_est{R, {3.0, -2.0, 7.0}};
  std::vector<MatchedPose> poses;
  for (std::size_t i = 0; i < 200; ++i) {
    const Pose estimate = testing::random_pose(generator, 5.0);
    Pose truth = T_true_est * estimate;
    truth.R = truth.R * so3_exp(testing::random_vector(generator, noise));
    poses.push_back(matched(i, estimate, truth));
  }
  return poses;
}

std::vector<PoseCovariance> with_sigma(double attitude) {
  PoseCovariance P = PoseCovariance::Identity();
  P.bottomRightCorner<3, 3>() *= attitude * attitude;
  return std::vector<PoseCovariance>(200, P);
}

TEST(WorldTilt, IsTheAngleBetweenTheVerticalsWhateverTheYaw) {
  for (const double degrees : {0.0, 3.5, 77.0, 90.0, 179.0}) {
    const Eigen::Matrix3d R =
        testing::yaw_rotation(130.0) * so3_exp(degrees * kDegree * Eigen::Vector3d(0.6, 0.8, 0.0));
    const WorldTilt tilt = world_tilt(seen_in(R)).value();
    EXPECT_NEAR(tilt.angle, degrees * kDegree, 1e-9);
    EXPECT_NEAR(tilt.spread, 0.0, 1e-7);
    EXPECT_FALSE(tilt.sigma);
    EXPECT_EQ(tilt.is_askew(), degrees > 3.0);
  }
}

TEST(WorldTilt, OfASmallOneIsAnErrorOfTheEstimate) {
  EXPECT_FALSE(world_tilt(seen_in(so3_exp({2.9 * kDegree, 0.0, 0.0})))->is_askew());
  EXPECT_TRUE(world_tilt(seen_in(so3_exp({3.1 * kDegree, 0.0, 0.0})))->is_askew());
}

TEST(WorldTilt, ThatIsNotTheSameThroughoutIsAnErrorOfTheEstimate) {
  const Eigen::Matrix3d R = so3_exp({20.0 * kDegree, 0.0, 0.0});
  EXPECT_TRUE(world_tilt(seen_in(R, 2.0 * kDegree))->is_askew());
  EXPECT_FALSE(world_tilt(seen_in(R, 10.0 * kDegree))->is_askew());
}

TEST(WorldTilt, ThatTheFilterAdmitsIsAnErrorOfTheEstimate) {
  const std::vector<MatchedPose> poses = seen_in(so3_exp({20.0 * kDegree, 0.0, 0.0}));
  const WorldTilt sure = world_tilt(poses, with_sigma(1.0 * kDegree)).value();
  EXPECT_NEAR(sure.sigma.value(), std::sqrt(2.0) * kDegree, 1e-12);  // about two axes
  EXPECT_TRUE(sure.is_askew());
  EXPECT_FALSE(world_tilt(poses, with_sigma(4.0 * kDegree))->is_askew());
}

TEST(WorldTilt, IsNothingWithoutPosesOrAMean) {
  EXPECT_FALSE(world_tilt({}));
  std::vector<MatchedPose> poses = {matched(0, {}, {}), matched(1, {}, {so3_exp({M_PI, 0.0, 0.0}), {}})};
  poses[1].truth.p.setZero();
  EXPECT_FALSE(world_tilt(poses));
  EXPECT_THROW((void)world_tilt(seen_in(testing::yaw_rotation(0.0)), std::vector<PoseCovariance>(3)),
               std::invalid_argument);
}

TEST(AlignUpright, LeavesWhatALevelTruthWouldLeave) {
  // The same errors beside a truth that is level, and one that lies on its side.
  std::vector<MatchedPose> level = seen_in(testing::yaw_rotation(40.0), 0.5 * kDegree);
  std::vector<MatchedPose> askew = level;
  const Pose T_side_level{so3_exp({0.3, 1.2, 0.0}), {1.0, 2.0, 3.0}};
  for (MatchedPose& pose : askew) {
    pose.truth = T_side_level * pose.truth;
  }
  const WorldTilt tilt = world_tilt(askew).value();
  ASSERT_TRUE(tilt.is_askew());
  const PoseErrorStatistics expected =
      absolute_errors(level, align_upright(level, world_tilt(level).value()));
  const PoseErrorStatistics found = absolute_errors(askew, align_upright(askew, tilt));
  EXPECT_NEAR(found.position_m.rmse, expected.position_m.rmse, 1e-9);
  EXPECT_NEAR(found.attitude_deg.rmse, expected.attitude_deg.rmse, 1e-6);
  EXPECT_LT(found.attitude_deg.rmse, 1.0);
  const Alignment upright = align_upright(askew, tilt);
  EXPECT_NEAR(((upright * askew[0].estimate).p - askew[0].truth.p).norm(), 0.0, 1e-12);
}

}  // namespace
}  // namespace limber
