// SPDX-License-Identifier: MIT
#include "limber/evaluate/consistency.hpp"
#include "limber/core/factors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

#include "evaluate/square.hpp"
#include "limber/core/so3.hpp"
#include "random_geometry.hpp"

namespace limber {
namespace {

using testing::Generator;
using testing::matched;

PoseCovariance random_covariance(Generator& generator) {
  PoseCovariance A;
  for (Eigen::Index k = 0; k < A.size(); ++k) {
    A(k) = testing::random_scalar(generator, -0.1, 0.1);
  }
  return A * A.transpose() + 1e-4 * PoseCovariance::Identity();
}

PoseErrorVector random_error(Generator& generator, const PoseCovariance& P) {
  std::normal_distribution<double> normal;
  PoseErrorVector white;
  for (Eigen::Index k = 0; k < 6; ++k) {
    white(k) = normal(generator);
  }
  return Cholesky(P).L() * white;
}

// A run whose errors are drawn from its own covariances.
struct DrawnRun {
  std::vector<MatchedPose> poses;
  std::vector<PoseCovariance> covariances;
};

DrawnRun consistent_run(Generator& generator, std::size_t frames) {
  DrawnRun run;
  for (std::size_t i = 0; i < frames; ++i) {
    const PoseCovariance P = random_covariance(generator);
    const PoseErrorVector error = random_error(generator, P);
    const Pose estimate = testing::random_pose(generator, 10.0);
    const Pose truth{estimate.R * so3_exp(error.tail<3>()), estimate.p + error.head<3>()};
    run.poses.push_back(matched(i, estimate, truth));
    run.covariances.push_back(P);
  }
  return run;
}

TEST(PoseError, IsTrueMinusEstimateInTheWorldAndLocalInAttitude) {
  const Pose estimate{testing::yaw_rotation(90.0), {1.0, 2.0, 3.0}};
  const Pose truth{estimate.R * so3_exp({0.1, 0.0, 0.0}), {1.5, 2.0, 2.0}};
  const PoseErrorVector error = pose_error(estimate, truth);
  EXPECT_TRUE(error.head<3>().isApprox(Eigen::Vector3d(0.5, 0.0, -1.0), 1e-14));
  EXPECT_TRUE(error.tail<3>().isApprox(Eigen::Vector3d(0.1, 0.0, 0.0), 1e-13));
}

TEST(PoseNees, UsesCrossCovariance) {
  // Position x and roll with correlation 0.5: (1 - 2 * 0.5 + 1) / (1 - 0.25) = 4/3.
  PoseCovariance P = PoseCovariance::Identity();
  P(0, 3) = P(3, 0) = 0.5;
  PoseErrorVector error = PoseErrorVector::Zero();
  error(0) = error(3) = 1.0;
  const auto nees = pose_nees(error, P);
  ASSERT_TRUE(nees);
  EXPECT_NEAR(nees->pose, 4.0 / 3.0, 1e-14);
  EXPECT_NEAR(nees->position, 1.0, 1e-14);
  EXPECT_NEAR(nees->attitude, 1.0, 1e-14);
}

TEST(PoseNees, RefusesACovarianceThatIsNone) {
  PoseCovariance P = PoseCovariance::Identity();
  P(4, 4) = -1e-9;
  EXPECT_FALSE(pose_nees(PoseErrorVector::Zero(), P));
  P(4, 4) = std::nan("");
  EXPECT_FALSE(pose_nees(PoseErrorVector::Zero(), P));
  EXPECT_FALSE(pose_nees(PoseErrorVector::Zero(), PoseCovariance::Zero()));
}

TEST(AverageNees, OfAConsistentRunIsOne) {
  // One seed, 3000 independent frames; a correct average leaves these intervals once in 10^6 runs.
  Generator generator(5);
  const DrawnRun run = consistent_run(generator, 3000);
  const Consistency c = average_nees(run.poses, run.covariances, Alignment{}, run.poses.front().t_ns);
  EXPECT_EQ(c.frames, 3000u - 11u);  // 0.0 to 1.0 s in steps of 0.1 s
  EXPECT_EQ(c.frames_refused, 0u);
  ASSERT_TRUE(c.anees);
  const Interval pose = normalized_mean_interval(6.0, c.frames, 1.0 - 1e-6);
  const Interval triplet = normalized_mean_interval(3.0, c.frames, 1.0 - 1e-6);
  EXPECT_GT(c.anees->pose, pose.lower);
  EXPECT_LT(c.anees->pose, pose.upper);
  EXPECT_GT(c.anees->position, triplet.lower);
  EXPECT_LT(c.anees->position, triplet.upper);
  EXPECT_GT(c.anees->attitude, triplet.lower);
  EXPECT_LT(c.anees->attitude, triplet.upper);
  EXPECT_NEAR(c.share_within_95, 0.95, 0.02);
}

TEST(AverageNees, OfAFilterThatHalvesItsSigmaIsFour) {
  Generator generator(6);
  DrawnRun run = consistent_run(generator, 3000);
  for (PoseCovariance& P : run.covariances) {
    P *= 0.25;
  }
  EXPECT_NEAR(average_nees(run.poses, run.covariances, Alignment{}, 0).anees->pose, 4.0, 0.2);
}

TEST(AverageNees, TakesFramesLaterThanOneSecondOnly) {
  std::vector<MatchedPose> poses;
  for (std::size_t i = 0; i <= 20; ++i) {
    Pose truth;
    truth.p.x() = i <= 10 ? 100.0 : std::sqrt(6.0);
    poses.push_back(matched(i, {}, truth));
  }
  const std::vector<PoseCovariance> covariances(21, PoseCovariance::Identity());
  const Consistency c = average_nees(poses, covariances, Alignment{}, 0);
  EXPECT_EQ(c.frames, 10u);
  EXPECT_NEAR(c.anees->pose, 1.0, 1e-14);
  EXPECT_NEAR(c.anees->position, 2.0, 1e-14);
  EXPECT_NEAR(c.anees->attitude, 0.0, 1e-14);
  EXPECT_EQ(c.share_within_95, 1.0);
  EXPECT_FALSE(average_nees(std::span(poses).first(11), covariances, Alignment{}, 0).anees);
}

TEST(AverageNees, DoesNotDependOnTheWorldTheEstimateLivesIn) {
  Generator generator(7);
  const DrawnRun run = consistent_run(generator, 50);
  // The same run, its world moved and turned by T: positions, their errors and their covariance turn with it.
  const Pose T{testing::yaw_rotation(70.0), {5.0, -3.0, 1.0}};
  DrawnRun moved = run;
  for (std::size_t i = 0; i < run.poses.size(); ++i) {
    moved.poses[i].estimate = T * run.poses[i].estimate;
    PoseCovariance G = PoseCovariance::Identity();
    G.topLeftCorner<3, 3>() = T.R;
    moved.covariances[i] = G * run.covariances[i] * G.transpose();
  }
  Alignment back;
  back.T_true_est = T.inverse();
  const auto expected = average_nees(run.poses, run.covariances, Alignment{}, 0).anees;
  const auto found = average_nees(moved.poses, moved.covariances, back, 0).anees;
  ASSERT_TRUE(expected && found);
  EXPECT_NEAR(found->pose, expected->pose, 1e-8);
  EXPECT_NEAR(found->position, expected->position, 1e-8);
  EXPECT_NEAR(found->attitude, expected->attitude, 1e-8);
}

TEST(AverageNees, CountsFramesWhoseCovarianceBroke) {
  Generator generator(8);
  DrawnRun run = consistent_run(generator, 30);
  run.covariances[20](2, 2) = -1.0;
  const Consistency c = average_nees(run.poses, run.covariances, Alignment{}, 0);
  EXPECT_EQ(c.frames_refused, 1u);
  EXPECT_EQ(c.frames, 18u);
}

TEST(AverageNees, RefusesMissingCovariancesAndScale) {
  Generator generator(9);
  const DrawnRun run = consistent_run(generator, 20);
  EXPECT_THROW((void)average_nees(run.poses, std::span(run.covariances).first(19), Alignment{}, 0),
               std::invalid_argument);
  Alignment scaled;
  scaled.scale = 1.1;
  EXPECT_THROW((void)average_nees(run.poses, run.covariances, scaled, 0), std::invalid_argument);
}

TEST(DistanceNees, SeesTheErrorAlongTheWayAlone) {
  PoseCovariance P = PoseCovariance::Identity();
  P(0, 0) = 4.0;
  PoseErrorVector error = PoseErrorVector::Zero();
  error << 6.0, 5.0, -7.0, 1.0, 1.0, 1.0;
  EXPECT_DOUBLE_EQ(*distance_nees(error, P, {10.0, 0.0, 0.0}), 9.0);
  EXPECT_DOUBLE_EQ(*distance_nees(error, P, {0.0, -3.0, 0.0}), 25.0);
  EXPECT_FALSE(distance_nees(error, P, Eigen::Vector3d::Zero()));
  P(0, 0) = -1.0;
  EXPECT_FALSE(distance_nees(error, P, {10.0, 0.0, 0.0}));
}

TEST(AverageNees, OfAPathThatIsTooLongIsLargeInScale) {
  // A path of 20 m that is one percent too long, by a filter that claims 5 cm everywhere.
  std::vector<MatchedPose> poses;
  std::vector<PoseCovariance> covariances;
  double expected = 0.0;
  for (std::size_t k = 0; k <= 20; ++k) {
    const Eigen::Vector3d p(static_cast<double>(k), 0.0, 0.0);
    poses.push_back({static_cast<std::int64_t>(k) * 1'000'000'000,
                     k,
                     {Eigen::Matrix3d::Identity(), 1.01 * p},
                     {Eigen::Matrix3d::Identity(), p}});
    covariances.emplace_back(0.05 * 0.05 * PoseCovariance::Identity());
    if (k > 1) {
      expected += std::pow(0.01 * p.x() / 0.05, 2.0) / 19.0;
    }
  }
  const Consistency found = average_nees(poses, covariances, Alignment{}, 0);
  EXPECT_NEAR(*found.anees_scale, expected, 1e-9);
  EXPECT_NEAR(found.anees->position, expected / 3.0, 1e-9);
}

TEST(NormalizedMeanInterval, IsThatOfTheTextbook) {
  // [BarShalom2001], example of 50 runs with two d.o.f.: chi-square(100) between 74.2 and 129.6.
  const Interval interval = normalized_mean_interval(2.0, 50, 0.95);
  EXPECT_NEAR(interval.lower, 0.742, 5e-4);
  EXPECT_NEAR(interval.upper, 1.296, 5e-4);
  EXPECT_THROW((void)normalized_mean_interval(2.0, 0), std::invalid_argument);
  EXPECT_THROW((void)normalized_mean_interval(2.0, 5, 1.0), std::invalid_argument);
}

TEST(AverageNis, AddsUpUpdatesOfDifferentSize) {
  const auto average = average_nis(std::vector<NisSample>{{3.0, 2.0}, {0.0, 0.0}, {9.0, 10.0}});
  ASSERT_TRUE(average);
  EXPECT_EQ(average->updates, 3u);
  EXPECT_EQ(average->dof, 12.0);
  EXPECT_DOUBLE_EQ(average->per_dof, 1.0);
  // chi-square(12) is 4.404 at 2.5 % and 23.337 at 97.5 %; P(X > 12) = exp(-6) (1 + 6 + 18 + 36 + 54 + 64.8).
  EXPECT_NEAR(average->interval.lower, 4.404 / 12.0, 1e-4);
  EXPECT_NEAR(average->interval.upper, 23.337 / 12.0, 1e-4);
  EXPECT_NEAR(average->p_value, std::exp(-6.0) * 179.8, 1e-12);
}

TEST(AverageNis, NeedsDegreesOfFreedomAndFiniteValues) {
  EXPECT_FALSE(average_nis({}));
  EXPECT_FALSE(average_nis(std::vector<NisSample>{{0.0, 0.0}}));
  EXPECT_THROW((void)average_nis(std::vector<NisSample>{{-1.0, 2.0}}), std::invalid_argument);
  EXPECT_THROW((void)average_nis(std::vector<NisSample>{{std::nan(""), 2.0}}), std::invalid_argument);
}

}  // namespace
}  // namespace limber
