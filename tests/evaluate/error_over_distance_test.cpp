// SPDX-License-Identifier: MIT
#include "limber/evaluate/error_over_distance.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "evaluate/square.hpp"
#include "limber/evaluate/trajectory_error.hpp"

namespace limber {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::matched;

/// Along x, 0.1 m a pose; the estimate is `scale` times as far and turns by `yaw_deg` a metre.
std::vector<MatchedPose> straight(std::size_t poses, double scale = 1.0, double yaw_deg = 0.0) {
  std::vector<MatchedPose> out;
  for (std::size_t i = 0; i < poses; ++i) {
    const double x = 0.1 * static_cast<double>(i);
    out.push_back(matched(i, {testing::yaw_rotation(yaw_deg * x), {scale * x, 0.0, 0.0}},
                          {Eigen::Matrix3d::Identity(), {x, 0.0, 0.0}}));
  }
  return out;
}

TEST(RoundDistances, LieBetweenAHundredthAndHalfOfThePath) {
  EXPECT_THAT(round_distances(straight(401)),
              ElementsAre(::testing::DoubleEq(0.5), ::testing::DoubleEq(1.0), ::testing::DoubleEq(2.0),
                          ::testing::DoubleEq(5.0), ::testing::DoubleEq(10.0), ::testing::DoubleEq(20.0)));
  EXPECT_THAT(round_distances({}), IsEmpty());
  EXPECT_THAT(round_distances(straight(1)), IsEmpty());
}

TEST(ErrorOverDistance, OfAScaleIsTheSameShareOfEveryLength) {
  const auto errors = errors_over_distances(straight(401, 1.02), std::vector{1.0, 10.0});
  ASSERT_EQ(errors.size(), 2U);
  for (const ErrorOverDistance& error : errors) {
    EXPECT_NEAR(error.position_percent.median, 2.0, 0.2);  // pieces end at poses
    EXPECT_NEAR(error.attitude_deg.upper, 0.0, 1e-9);
  }
  EXPECT_GT(errors[0].pairs, errors[1].pairs);
}

TEST(ErrorOverDistance, OfADriftOfHeadingGrowsWithTheLength) {
  const auto errors = errors_over_distances(straight(401, 1.0, 0.5), std::vector{1.0, 10.0});
  EXPECT_NEAR(errors[0].attitude_deg.median, 0.5, 1e-6);
  EXPECT_NEAR(errors[1].attitude_deg.median, 5.0, 1e-6);
}

TEST(ErrorOverDistance, IsThatOfRelativeErrors) {
  const std::vector<MatchedPose> poses = straight(300, 1.05, 1.0);
  const auto pairs = pairs_by_path(poses, 5.0);
  const auto expected = relative_errors(poses, pairs).value();
  const auto found = errors_over_distances(poses, std::vector{5.0});
  EXPECT_EQ(found[0].pairs, pairs.size());
  EXPECT_NEAR(found[0].position_percent.mean, 100.0 * expected.position_m.mean / 5.0, 1e-12);
  EXPECT_NEAR(found[0].attitude_deg.mean, expected.attitude_deg.mean, 1e-12);
}

TEST(ErrorOverDistance, KnowsItsQuartiles) {
  std::vector<MatchedPose> poses = straight(5);  // pieces of 0.1 m, 0, 1, 2 and 3 degrees off
  for (std::size_t i = 1; i < poses.size(); ++i) {
    poses[i].estimate.R = testing::yaw_rotation(0.5 * static_cast<double>(i * (i - 1)));
  }
  const auto errors = errors_over_distances(poses, std::vector{0.1});
  ASSERT_EQ(errors[0].pairs, 4U);
  EXPECT_NEAR(errors[0].attitude_deg.mean, 1.5, 1e-9);
  EXPECT_NEAR(errors[0].attitude_deg.lower, 1.0, 1e-9);
  EXPECT_NEAR(errors[0].attitude_deg.upper, 2.0, 1e-9);
}

TEST(ErrorOverDistance, LeavesOutWhatThePathIsTooShortFor) {
  EXPECT_EQ(errors_over_distances(straight(21), std::vector{1.0, 5.0}).size(), 1U);
  EXPECT_THROW((void)errors_over_distances(straight(21), std::vector{0.0}), std::invalid_argument);
}

}  // namespace
}  // namespace limber
