// SPDX-License-Identifier: MIT
#include "limber/evaluate/association.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "evaluate/square.hpp"

namespace limber {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000;

StampedPose at(std::int64_t t_ms, double x, double yaw_deg = 0.0) {
  return {t_ms * kMillisecond, {testing::yaw_rotation(yaw_deg), {x, 0.0, 0.0}}};
}

double yaw_deg(const Pose& pose) { return std::atan2(pose.R(1, 0), pose.R(0, 0)) / testing::kDegree; }

TEST(MatchByTime, InterpolatesTheTruthBetweenItsSamples) {
  const std::vector truth{at(984, 100.0), at(1000, 1.0, 10.0), at(1016, 5.0, 50.0), at(1032, -100.0)};
  const auto poses = match_by_time(std::vector{at(1004, 7.0), at(1012, 8.0)}, truth);
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_EQ(poses[0].t_ns, 1004 * kMillisecond);
  EXPECT_EQ(poses[0].estimate.p.x(), 7.0);
  EXPECT_NEAR(poses[0].truth.p.x(), 2.0, 1e-12);
  EXPECT_NEAR(yaw_deg(poses[0].truth), 20.0, 1e-10);
  EXPECT_NEAR(poses[1].truth.p.x(), 4.0, 1e-12);
  EXPECT_NEAR(yaw_deg(poses[1].truth), 40.0, 1e-10);
}

TEST(MatchByTime, TurnsTheShortWay) {
  const auto poses =
      match_by_time(std::vector{at(5, 0.0)}, std::vector{at(0, 0.0, 170.0), at(10, 0.0, -170.0)});
  ASSERT_EQ(poses.size(), 1u);
  EXPECT_NEAR(std::abs(yaw_deg(poses[0].truth)), 180.0, 1e-10);
}

TEST(MatchByTime, TakesTheSampleItselfWhereTimesAgree) {
  const std::vector truth{at(0, 0.1), at(10, 0.2), at(20, 0.7)};
  const auto poses = match_by_time(std::vector{at(0, 0.0), at(10, 0.0), at(20, 0.0)}, truth);
  ASSERT_EQ(poses.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(poses[i].truth.p.x(), truth[i].T_world_body.p.x());
  }
}

TEST(MatchByTime, LeavesOutWhatIsFartherThanTheLimit) {
  const std::vector truth{at(0, 0.0), at(1000, 1.0)};
  std::vector<StampedPose> estimate{at(10, 0.0), at(500, 0.0), at(990, 0.0)};
  auto poses = match_by_time(estimate, truth);
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_EQ(poses[0].index, 0u);
  EXPECT_EQ(poses[1].index, 2u);
  EXPECT_NEAR(poses[1].truth.p.x(), 0.99, 1e-12);

  estimate[0].t_ns += 1;
  estimate[2].t_ns -= 1;
  EXPECT_TRUE(match_by_time(estimate, truth).empty());
  EXPECT_EQ(match_by_time(estimate, truth, 0.6).size(), 3u);
}

TEST(MatchByTime, ContinuesTheTruthJustBeyondItsEnds) {
  const std::vector truth{at(0, 0.0), at(100, 1.0), at(200, 3.0)};
  const auto poses = match_by_time(std::vector{at(-5, 0.0), at(205, 0.0)}, truth);
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_NEAR(poses[0].truth.p.x(), -0.05, 1e-12);
  EXPECT_NEAR(poses[1].truth.p.x(), 3.1, 1e-12);
}

TEST(MatchByTime, CopesWithOneSampleAndWithNone) {
  const auto poses = match_by_time(std::vector{at(3, 0.0)}, std::vector{at(0, 2.0)});
  ASSERT_EQ(poses.size(), 1u);
  EXPECT_EQ(poses[0].truth.p.x(), 2.0);
  EXPECT_TRUE(match_by_time(std::vector{at(3, 0.0)}, {}).empty());
  EXPECT_TRUE(match_by_time({}, std::vector{at(0, 2.0)}).empty());
}

TEST(MatchByTime, RefusesTimesThatDoNotIncreaseAndPosesThatAreNotFinite) {
  const std::vector good{at(0, 0.0), at(10, 1.0)};
  const std::vector twice{at(0, 0.0), at(0, 1.0)};
  const std::vector nan{at(0, 0.0), at(10, std::nan(""))};
  EXPECT_THROW((void)match_by_time(twice, good), std::invalid_argument);
  EXPECT_THROW((void)match_by_time(good, twice), std::invalid_argument);
  EXPECT_THROW((void)match_by_time(nan, good), std::invalid_argument);
  EXPECT_THROW((void)match_by_time(good, nan), std::invalid_argument);
  EXPECT_THROW((void)match_by_time(good, good, -1.0), std::invalid_argument);
  EXPECT_THROW((void)match_by_time(good, good, std::nan("")), std::invalid_argument);
}

TEST(MatchByIndex, PairsLineByLine) {
  const auto poses = match_by_index(std::vector{at(0, 1.0), at(1, 2.0)}, std::vector{at(0, 3.0), at(7, 4.0)});
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_EQ(poses[1].index, 1u);
  EXPECT_EQ(poses[1].t_ns, kMillisecond);
  EXPECT_EQ(poses[1].estimate.p.x(), 2.0);
  EXPECT_EQ(poses[1].truth.p.x(), 4.0);
}

TEST(MatchByIndex, RefusesListsOfDifferentLength) {
  EXPECT_THROW((void)match_by_index(std::vector{at(0, 1.0)}, {}), std::invalid_argument);
}

}  // namespace
}  // namespace limber
