// SPDX-License-Identifier: MIT
#include "limber/landmarks/map_management.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <utility>

#include "landmarks/pinhole_at_the_body.hpp"
#include "state/small_map.hpp"

namespace limber {
namespace {

using Eigen::Vector3d;
using testing::Generator;

constexpr std::int64_t kSecond = 1000000000;
constexpr std::int64_t kPresent = 100 * kSecond;

/// Options under which nothing happens.
MapManagementOptions idle() {
  MapManagementOptions options;
  options.max_landmarks = 1000;
  options.linearity_index = 0.0;
  return options;
}

/// An estimate at the origin that looks along z, with an inverse-depth landmark `depth` before it.
Estimate before_a_point(double depth, double sigma_rho) {
  Estimate estimate = testing::empty_map();
  testing::add_landmark_ahead(estimate, 1, depth, sigma_rho, kPresent);
  return estimate;
}

TEST(LinearityIndex, IsFourSigmasOfDepthOverTheDistanceTimesTheParallax) {
  Estimate estimate = before_a_point(5.0, 0.01);
  // sigma_d = sigma_rho d² = 0.25 m; from the anchor: 4 · 0.25 / 5.
  EXPECT_NEAR(linearity_index(estimate, *estimate.find(1)), 0.2, 1e-12);
  // From the side, 5 m away at a right angle to the ray: no depth error is seen as such.
  testing::move_body(estimate, [&](NavigationState& nav) { nav.T_world_body.p << 5.0, 0.0, 5.0; });
  EXPECT_NEAR(linearity_index(estimate, *estimate.find(1)), 0.0, 1e-12);
  // At 60 degrees.
  testing::move_body(estimate, [&](NavigationState& nav) {
    nav.T_world_body.p = Vector3d(0.0, 0.0, 5.0) - 2.0 * Vector3d(std::sqrt(0.75), 0.0, 0.5);
  });
  EXPECT_NEAR(linearity_index(estimate, *estimate.find(1)), 4.0 * 0.25 / 2.0 * 0.5, 1e-12);
}

TEST(LinearityIndex, IsInfiniteBeyondInfinityAndZeroForACartesianPoint) {
  Estimate estimate = before_a_point(5.0, 0.01);
  estimate.find(1)->value.z() = -0.01;
  EXPECT_EQ(linearity_index(estimate, *estimate.find(1)), std::numeric_limits<double>::infinity());
  estimate.find(1)->value.z() = 0.2;
  estimate.convert_to_cartesian(*estimate.find(1));
  EXPECT_EQ(linearity_index(estimate, *estimate.find(1)), 0.0);
}

TEST(MapManagement, ConvertsALandmarkThatIsLinearEnoughAndJustSeen) {
  MapManagementOptions options = idle();
  options.linearity_index = 0.1;
  const auto kind_after = [&](double sigma_rho, std::int64_t last_seen_ns) {
    Estimate estimate = before_a_point(5.0, sigma_rho);
    estimate.find(1)->last_seen_ns = last_seen_ns;
    EXPECT_EQ(manage_map(estimate, kPresent, options), 0U);
    return estimate.find(1)->kind;
  };
  EXPECT_EQ(kind_after(0.004, kPresent), LandmarkKind::kCartesian);
  EXPECT_EQ(kind_after(0.006, kPresent), LandmarkKind::kInverseDepth);
  EXPECT_EQ(kind_after(0.004, kPresent - kSecond), LandmarkKind::kInverseDepth);
}

/// A Cartesian landmark on the camera's axis, 5 m away, with the standard deviations `sigma`, seen now.
Estimate before_a_cartesian_point(const Vector3d& sigma) {
  Estimate estimate({MotionModel::kOdometry, false}, {}, 1e-16 * Eigen::MatrixXd::Identity(6, 6),
                    RigParameters::Zero(), Eigen::Matrix<double, 6, 6>::Identity());
  Landmark landmark;
  landmark.track_id = 1;
  landmark.kind = LandmarkKind::kCartesian;
  landmark.value << 0.0, 0.0, 5.0;
  landmark.last_seen_ns = kPresent;
  estimate.add_landmark(landmark, sigma.cwiseAbs2().asDiagonal());
  return estimate;
}

TEST(ProjectionCurvature, IsThePixelsSigmaTimesTheRelativeDepths) {
  const Estimate estimate = before_a_cartesian_point({0.03, 0.04, 0.5});
  // 0.05 m at 5 m are 1 px; the depth is known to 10 %.
  EXPECT_NEAR(projection_curvature(estimate, *estimate.find(1), testing::pinhole_at_the_body()), 0.1, 1e-9);
}

TEST(ProjectionCurvature, DoesNotSeeWhatPoseAndLandmarkShare) {
  Estimate estimate = before_a_cartesian_point({0.3, 0.4, 1.0});
  // The body is as uncertain as the point, and in the same way.
  const Eigen::Index at = estimate.find(1)->at;
  Eigen::MatrixXd columns;
  estimate.P().gather(std::vector<Eigen::Index>{at}, columns);
  columns.topRows<3>() = columns.middleRows<3>(at).eval();
  estimate.mutable_P().scatter(std::vector<Eigen::Index>{0}, columns);
  EXPECT_LE(projection_curvature(estimate, *estimate.find(1), testing::pinhole_at_the_body()), 1e-6);
}

TEST(ProjectionCurvature, IsInfiniteWhereThePointDoesNotProject) {
  Estimate estimate = before_a_cartesian_point({0.03, 0.04, 0.5});
  estimate.find(1)->value.z() = -5.0;
  EXPECT_EQ(projection_curvature(estimate, *estimate.find(1), testing::pinhole_at_the_body()),
            std::numeric_limits<double>::infinity());
}

TEST(ForgetMisplaced, RemovesOfTheReturningOnlyWhatIsCurved) {
  StereoFrame frame;
  frame.t_ns = kPresent + 2 * kSecond;
  frame.observations.resize(2);
  frame.observations[0].track_id = 1;
  frame.observations[1].track_id = 77;  // unknown: no harm
  MapManagementOptions options;
  const auto forgotten = [&](double depth_sigma, std::int64_t previous_ns, bool observed) {
    Estimate estimate = before_a_cartesian_point({0.03, 0.04, depth_sigma});
    options.max_curvature_px = 0.25;
    StereoFrame seen = frame;
    seen.observations[0].track_id = observed ? 1 : 2;
    const std::size_t count =
        forget_misplaced(estimate, seen, previous_ns, testing::pinhole_at_the_body(), options);
    EXPECT_EQ(estimate.find(1) == nullptr, count == 1);
    return count;
  };
  EXPECT_EQ(forgotten(1.5, kPresent + kSecond, true), 1U);   // 0.3 px
  EXPECT_EQ(forgotten(1.0, kPresent + kSecond, true), 0U);   // 0.2 px
  EXPECT_EQ(forgotten(1.5, kPresent, true), 0U);             // seen in the frame before
  EXPECT_EQ(forgotten(1.5, kPresent + kSecond, false), 0U);  // not back
}

/// Initialised 5 m away under a doubtful calibration; now at `depth`.
Estimate moved_to(double depth, double sigma_rho) {
  Estimate estimate = before_a_point(depth, sigma_rho);
  estimate.find(1)->rho_assumed = 0.2;
  return estimate;
}

TEST(DepthShift, IsTheShareByWhichTheInverseDepthMoved) {
  const auto shift = [](const Estimate& estimate) { return depth_shift(estimate, *estimate.find(1)); };
  EXPECT_NEAR(shift(moved_to(4.0, 0.01)), 0.25, 1e-12);
  EXPECT_NEAR(shift(moved_to(8.0, 0.01)), 0.375, 1e-12);
  EXPECT_EQ(shift(moved_to(4.0, 0.06)), 0.0);  // not known better than it moved
  EXPECT_EQ(shift(before_a_point(4.0, 0.01)), 0.0);
  Estimate cartesian = moved_to(4.0, 0.01);
  cartesian.convert_to_cartesian(*cartesian.find(1));
  EXPECT_EQ(shift(cartesian), 0.0);
}

TEST(ForgetMisplaced, RemovesWhatTurnsOutToLieElsewhere) {
  StereoFrame frame;
  frame.t_ns = kPresent;
  frame.observations.resize(1);
  frame.observations[0].track_id = 1;
  for (const auto& [depth, gone] : {std::pair{5.4, 0U}, {5.6, 1U}, {4.6, 0U}, {4.4, 1U}}) {
    Estimate estimate = moved_to(depth, 0.001);
    EXPECT_EQ(
        forget_misplaced(estimate, frame, kPresent, testing::pinhole_at_the_body(), MapManagementOptions{}),
        gone)
        << depth;
    EXPECT_EQ(estimate.find(1) == nullptr, gone == 1) << depth;
  }
}

TEST(ForgetMisplaced, RemovesWhoseDepthWasGuessedWhenTheRightCameraTellsIt) {
  StereoFrame frame;
  frame.t_ns = kPresent;
  frame.observations.resize(1);
  frame.observations[0].track_id = 1;
  const auto forgotten = [&](bool guessed, bool in_cam1, double share) {
    Estimate estimate = before_a_point(5.0, share / 5.0);
    estimate.find(1)->depth_guessed = guessed;
    frame.observations[0].in_cam1 = in_cam1;
    const std::size_t count =
        forget_misplaced(estimate, frame, kPresent, testing::pinhole_at_the_body(), MapManagementOptions{});
    if (count == 0) {
      EXPECT_EQ(estimate.find(1)->depth_guessed, guessed && !in_cam1);
    }
    return count;
  };
  EXPECT_EQ(forgotten(true, true, 0.11), 1U);
  EXPECT_EQ(forgotten(true, true, 0.09), 0U);  // its parallax has told
  EXPECT_EQ(forgotten(true, false, 0.11), 0U);
  EXPECT_EQ(forgotten(false, true, 0.11), 0U);
}

std::vector<std::int64_t> ids(const Estimate& estimate) { return testing::snapshot(estimate).track_ids; }

/// Landmarks 0 to 9; the k-th was last seen 10 − k seconds ago, but 8 and 9 just now.
Estimate aging_map(Generator& generator) {
  Estimate estimate = testing::random_map(generator, 10);
  for (Landmark& landmark : estimate.landmarks()) {
    const std::int64_t age = landmark.track_id >= 8 ? 0 : 10 - landmark.track_id;
    landmark.last_seen_ns = kPresent - age * kSecond;
  }
  return estimate;
}

TEST(MapManagement, RemovesNothingWithoutReason) {
  Generator generator(1);
  Estimate estimate = aging_map(generator);
  const testing::Snapshot before = testing::snapshot(estimate);
  EXPECT_EQ(manage_map(estimate, kPresent, idle()), 0U);
  EXPECT_EQ(testing::snapshot(estimate), before);
}

TEST(MapManagement, BeyondTheMostLandmarksThoseUnseenForLongestGo) {
  Generator generator(2);
  Estimate estimate = aging_map(generator);
  MapManagementOptions options = idle();
  options.max_landmarks = 6;
  EXPECT_EQ(manage_map(estimate, kPresent, options), 4U);
  EXPECT_EQ(ids(estimate), (std::vector<std::int64_t>{4, 5, 6, 7, 8, 9}));
}

TEST(MapManagement, NeverRemovesForRoomWhatIsInView) {
  Generator generator(3);
  Estimate estimate = aging_map(generator);
  MapManagementOptions options = idle();
  options.max_landmarks = 1;
  EXPECT_EQ(manage_map(estimate, kPresent, options), 8U);
  EXPECT_EQ(ids(estimate), (std::vector<std::int64_t>{8, 9}));
}

TEST(MapManagement, OfThoseUnseenForEquallyLongTheOlderTrackGoes) {
  Generator generator(4);
  Estimate estimate = aging_map(generator);
  for (Landmark& landmark : estimate.landmarks()) {
    landmark.last_seen_ns = kPresent - kSecond;
  }
  MapManagementOptions options = idle();
  options.max_landmarks = 7;
  EXPECT_EQ(manage_map(estimate, kPresent, options), 3U);
  EXPECT_EQ(ids(estimate), (std::vector<std::int64_t>{3, 4, 5, 6, 7, 8, 9}));
}

TEST(MapManagement, ForgetsWhatWasUnseenForTooLong) {
  Generator generator(5);
  Estimate estimate = aging_map(generator);
  MapManagementOptions options = idle();
  options.forget_after_s = 6.5;
  EXPECT_EQ(manage_map(estimate, kPresent, options), 4U);
  EXPECT_EQ(ids(estimate), (std::vector<std::int64_t>{4, 5, 6, 7, 8, 9}));
}

TEST(MapManagement, RemovesWhatWasRefusedTooOften) {
  Generator generator(6);
  Estimate estimate = aging_map(generator);
  estimate.find(3)->refusals = 2;
  estimate.find(5)->refusals = 3;
  estimate.find(9)->refusals = 7;
  EXPECT_EQ(manage_map(estimate, kPresent, idle()), 2U);
  EXPECT_EQ(ids(estimate), (std::vector<std::int64_t>{0, 1, 2, 3, 4, 6, 7, 8}));
}

TEST(MapManagement, WhatOneRuleRemovesMakesRoomForTheOther) {
  Generator generator(7);
  Estimate estimate = aging_map(generator);
  estimate.find(9)->refusals = 3;
  MapManagementOptions options = idle();
  options.max_landmarks = 9;
  EXPECT_EQ(manage_map(estimate, kPresent, options), 1U);
}

}  // namespace
}  // namespace limber
