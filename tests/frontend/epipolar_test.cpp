// SPDX-License-Identifier: MIT
#include "frontend/epipolar.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "random_geometry.hpp"

namespace limber::frontend {
namespace {

using limber::testing::Generator;
using limber::testing::random_scalar;
using limber::testing::random_vector;

constexpr double kThreshold = 1.0 / 450.0;  ///< [rad] a pixel of an ordinary camera

const EpipolarGeometry kRig{so3_exp(Eigen::Vector3d(0.01, -0.02, 0.015)),
                            Eigen::Vector3d(-1.0, 0.03, 0.02).normalized()};

/// n pairs of points 1 to 20 m away, with noise [rad], seen over a baseline of 0.12 m.
std::vector<BearingPair> random_pairs(const EpipolarGeometry& rig, int n, double sigma,
                                      Generator& generator) {
  std::vector<BearingPair> pairs;
  for (int i = 0; i < n; ++i) {
    const Eigen::Vector3d direction{random_scalar(generator, -0.7, 0.7), random_scalar(generator, -0.5, 0.5),
                                    1.0};
    const Eigen::Vector3d X = direction / random_scalar(generator, 0.05, 1.0);
    const Eigen::Vector3d noise = random_vector(generator, sigma * std::sqrt(3.0));
    pairs.push_back({X.normalized(), ((rig.R_b_a * X + 0.12 * rig.t).normalized() + noise).normalized()});
  }
  return pairs;
}

/// Replaces the first `n` pairs by bearings that have nothing to do with each other.
void spoil(std::vector<BearingPair>& pairs, std::size_t n, Generator& generator) {
  for (std::size_t i = 0; i < n; ++i) {
    pairs[i].b =
        Eigen::Vector3d{random_scalar(generator, -0.7, 0.7), random_scalar(generator, -0.5, 0.5), 1.0}
            .normalized();
  }
}

long count(const std::vector<bool>& flags, std::size_t from = 0) {
  return std::count(flags.begin() + static_cast<std::ptrdiff_t>(from), flags.end(), true);
}

TEST(EpipolarDistance, IsZeroForExactPairsAndTheAngleOfASmallErrorShared) {
  Generator generator(1);
  for (const BearingPair& pair : random_pairs(kRig, 50, 0.0, generator)) {
    EXPECT_LT(epipolar_distance(kRig, pair), 1e-12);
    // Moved off its epipolar plane by 1 mrad; Sampson shares the error between the two bearings.
    const Eigen::Vector3d normal = kRig.t.cross(kRig.R_b_a * pair.a).normalized();
    const BearingPair moved{pair.a, (pair.b + 1e-3 * normal).normalized()};
    EXPECT_NEAR(epipolar_distance(kRig, moved), 1e-3 / std::sqrt(2.0), 1e-4);
  }
}

TEST(EpipolarDistance, IsZeroOnTheBaselineWhereEveryBearingFits) {
  const BearingPair pair{kRig.R_b_a.transpose() * kRig.t, kRig.t};
  EXPECT_EQ(epipolar_distance(kRig, pair), 0.0);
}

TEST(FitEpipolar, GoesOnFromAStartAndLeavesOneThatIsWrong) {
  Generator generator(5);
  const std::vector<BearingPair> pairs = random_pairs(kRig, 150, 0.2 * kThreshold, generator);
  const EpipolarGeometry near{kRig.R_b_a * so3_exp(Eigen::Vector3d(0.004, 0.003, -0.004)), kRig.t};
  const EpipolarGeometry wrong{kRig.R_b_a * so3_exp(Eigen::Vector3d(0.2, 0.0, 0.0)),
                               Eigen::Vector3d::UnitZ()};
  for (const EpipolarGeometry& start : {near, wrong}) {
    const auto geometry = fit_epipolar(pairs, kThreshold, start);
    ASSERT_TRUE(geometry);
    EXPECT_GE(count(epipolar_inliers(*geometry, pairs, kThreshold)), 147);
  }
}

TEST(FitEpipolar, FindsTheGeometryAmongOutliers) {
  Generator generator(2);
  std::vector<BearingPair> pairs = random_pairs(kRig, 150, 0.2 * kThreshold, generator);
  spoil(pairs, 45, generator);
  const auto geometry = fit_epipolar(pairs, kThreshold);
  ASSERT_TRUE(geometry);
  const std::vector<bool> inliers = epipolar_inliers(*geometry, pairs, kThreshold);
  EXPECT_GE(count(inliers, 45), 103);                      // of 105 good ones
  EXPECT_LE(count(inliers) - count(inliers, 45), 45 / 5);  // a wrong one may lie on its line by chance
  Generator fresh(3);
  EXPECT_EQ(count(epipolar_inliers(*geometry, random_pairs(kRig, 100, 0.0, fresh), kThreshold)), 100);
}

TEST(FitEpipolar, GivesNothingWithoutAMajorityOrWithFewPairs) {
  Generator generator(4);
  std::vector<BearingPair> pairs = random_pairs(kRig, 100, 0.2 * kThreshold, generator);
  spoil(pairs, 60, generator);
  EXPECT_FALSE(fit_epipolar(pairs, kThreshold));
  EXPECT_FALSE(fit_epipolar(random_pairs(kRig, kMinPairs - 1, 0.0, generator), kThreshold));
  EXPECT_FALSE(fit_epipolar({}, kThreshold));
}

TEST(FitEpipolar, RejectsNothingWhenNothingMoves) {
  Generator generator(5);
  for (const double sigma : {0.0, 1e-6, 0.2 * kThreshold}) {
    std::vector<BearingPair> pairs = random_pairs(kRig, 120, 0.0, generator);
    for (BearingPair& pair : pairs) {
      pair.b = (pair.a + random_vector(generator, sigma * std::sqrt(3.0))).normalized();
    }
    const auto geometry = fit_epipolar(pairs, kThreshold);
    if (geometry) {
      EXPECT_EQ(count(epipolar_inliers(*geometry, pairs, kThreshold)), 120) << sigma;
    }
  }
}

TEST(RefineEpipolar, ConvergesFromSomeThresholdsAway) {
  Generator generator(6);
  const std::vector<BearingPair> pairs = random_pairs(kRig, 200, 0.0, generator);
  const EpipolarGeometry start{kRig.R_b_a * so3_exp(Eigen::Vector3d(0.004, -0.003, 0.005)),
                               (kRig.t + Eigen::Vector3d(0.0, 0.02, -0.02)).normalized()};
  const EpipolarGeometry found = refine_epipolar(start, pairs, kThreshold);
  EXPECT_LT(so3_log(found.R_b_a.transpose() * kRig.R_b_a).norm(), 5e-4);
  for (const BearingPair& pair : pairs) EXPECT_LT(epipolar_distance(found, pair), 0.05 * kThreshold);
}

TEST(LeftRightConsensus, DropsWhatDisagreesWithTheOtherMatches) {
  Generator generator(7);
  LeftRightConsensus consensus(kThreshold);
  for (int frame = 0; frame < 15; ++frame) {
    std::vector<BearingPair> pairs = random_pairs(kRig, 80, 0.2 * kThreshold, generator);
    spoil(pairs, 16, generator);
    const std::vector<bool> agrees = consensus.judge(pairs);
    EXPECT_GE(count(agrees, 16), 63) << frame;
    EXPECT_LE(count(agrees) - count(agrees, 16), 5) << frame;
  }
}

TEST(LeftRightConsensus, FollowsARigThatShakesAndOneThatJumps) {
  Generator generator(8);
  LeftRightConsensus consensus(kThreshold);
  for (int frame = 0; frame < 40; ++frame) {
    EpipolarGeometry rig = kRig;
    const double jump = frame < 20 ? 0.0 : 0.05;  // 3 degrees about each axis, or 22 pixels
    rig.R_b_a = rig.R_b_a * so3_exp(Eigen::Vector3d(jump, -jump, jump) + random_vector(generator, 0.005));
    EXPECT_GE(count(consensus.judge(random_pairs(rig, 80, 0.2 * kThreshold, generator))), 78) << frame;
  }
}

TEST(LeftRightConsensus, TrustsNothingUntilEnoughMatchesAgree) {
  Generator generator(9);
  LeftRightConsensus few(kThreshold);
  for (int frame = 0; frame < 8; ++frame) {
    const long trusted = count(few.judge(random_pairs(kRig, 4, 0.1 * kThreshold, generator)));
    EXPECT_EQ(trusted, frame < 2 ? 0 : 4) << frame;  // three frames make kMinPairs
  }
  LeftRightConsensus nonsense(kThreshold);
  std::vector<BearingPair> pairs = random_pairs(kRig, 60, 0.0, generator);
  spoil(pairs, 60, generator);
  EXPECT_EQ(count(nonsense.judge(pairs)), 0);
  EXPECT_TRUE(nonsense.judge({}).empty());
}

}  // namespace
}  // namespace limber::frontend
