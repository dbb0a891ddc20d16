// SPDX-License-Identifier: MIT
#include "limber/health/rig_movement.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "health/stereo_world.hpp"
#include "limber/health/calibration_watch.hpp"

namespace limber {
namespace {

using testing::fly_past;
using testing::World;
using testing::WorldOptions;

constexpr double kHalfTurn = std::numbers::pi;

CalibrationState state_of_world(const WorldOptions& options) {
  const World world = fly_past(options);
  CalibrationWatch watch({}, world.assumed, true);
  for (std::size_t k = 0; k < world.frames.size(); ++k) {
    watch.add(world.frames[k], world.poses[k], {});
  }
  return watch.report()->state;
}

/// Errors that stay along a track and at a place of the image, as those of real pixels.
WorldOptions realistic(unsigned seed) {
  WorldOptions options;
  options.per_track_px = 0.3;
  options.per_cell_px = 0.1;
  options.seconds = 12.0;
  options.seed = seed;
  return options;
}

/// An axis that swings at 3.3 Hz, by so much [rad, m].
WorldOptions swinging(unsigned seed, Eigen::Index axis, double amplitude) {
  WorldOptions options = realistic(seed);
  options.error = [=](double t) {
    return RigParameters(amplitude * std::sin(2.0 * kHalfTurn * 3.3 * t) * RigParameters::Unit(axis));
  };
  return options;
}

/// Roll, in degrees.
WorldOptions vibrating(unsigned seed, double degrees) {
  return swinging(seed, 2, degrees * kHalfTurn / 180.0);
}

/// Depths swing by an amplitude of 20 %; seen is the root mean square.
void expect_depths_that_swing(Eigen::Index axis) {
  constexpr int kRuns = 20;
  const RigParameters slope = depth_slope(testing::world_calibration().theta, Tolerance{}.baselines);
  const double truth = 0.2 / std::sqrt(2.0);
  int held = 0;
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    const CalibrationState state = state_of_world(swinging(seed, axis, 0.2 / std::abs(slope(axis))));
    const SizeInterval& share = state.depth_movement.share;
    // About the mean of half a second; that of 1.65 periods is not quite zero.
    held += share.low <= 1.05 * truth && truth <= 1.05 * share.high ? 1 : 0;
    EXPECT_NEAR(share.size, truth, 0.1 * truth);
    EXPECT_EQ(state.depth_movement.axis, axis);
    EXPECT_TRUE(is_wrong(state.by_depth_movement)) << share.low;
    EXPECT_TRUE(is_wrong(state.verdict));
    EXPECT_EQ(state.named, static_cast<std::size_t>(axis));
  }
  EXPECT_GE(held, 16);  // 95 % of 20 runs, less three standard deviations
}

TEST(RigMovement, OfVibrationIsHeldByItsInterval) {
  constexpr int kRuns = 30;
  int held = 0;
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    const CalibrationState state = state_of_world(vibrating(seed, 0.2));
    const double plausible = 0.2 / 0.1 / std::sqrt(2.0);
    const double truth = plausible * std::sqrt(state.whole.epipolar(2, 2));
    held += state.movement.px.low <= truth && truth <= state.movement.px.high ? 1 : 0;
    EXPECT_NEAR(state.movement.px.size, truth, 0.05 * truth);
    EXPECT_EQ(state.movement.axis, 2);
    EXPECT_EQ(state.by_epipolar, HealthVerdict::kOk);  // on average
    EXPECT_EQ(state.verdict, HealthVerdict::kDegraded);
    EXPECT_EQ(state.named, 2u);
  }
  EXPECT_GE(held, 25);  // 95 % of 30 runs, less three standard deviations
}

TEST(RigMovement, OfASoundRigIsNoneWhateverItsTracksAndLensesDo) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const CalibrationState state = state_of_world(realistic(seed));
    EXPECT_LT(state.movement.px.low, 0.1);
    EXPECT_EQ(state.by_movement, HealthVerdict::kOk) << state.movement.px.high;
  }
}

TEST(RigMovement, OfVergenceShowsInDepths) { expect_depths_that_swing(1); }

TEST(RigMovement, OfTheBaselinesLengthShowsInDepths) { expect_depths_that_swing(3); }

TEST(RigMovement, OfDepthsOfASoundRigIsNoneWhateverItsTracksAndLensesDo) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const CalibrationState state = state_of_world(realistic(seed));
    EXPECT_LT(state.depth_movement.share.low, 0.015);
    EXPECT_EQ(state.by_depth_movement, HealthVerdict::kOk) << state.depth_movement.share.high;
  }
}

TEST(RigMovement, OfDepthsIsUnknownOfTooFewFrames) {
  const DepthMovement none =
      depth_movement_of(std::vector<DepthHalves>(5), testing::world_calibration().theta, 90.0);
  EXPECT_EQ(none.share.high, std::numeric_limits<double>::infinity());
}

/// Blocks of frames that say `turn` and `length` by turns with either sign, about a mean that drifts.
std::vector<DepthHalves> alternating(double turn, double length, const DepthHalves::Pair& px) {
  std::vector<DepthHalves> blocks(4);
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    std::vector<DepthHalves::Pair> said;
    for (int n = 0; n < 10; ++n) {
      said.emplace_back(DepthHalves::Pair(turn, length) * (n % 2 == 0 ? 1.0 : -1.0) +
                        5.0 * static_cast<double>(k));
    }
    blocks[k].add_stretch(said, said);
    blocks[k].px_squared = 10.0 * px;
    blocks[k].points = 10.0;
  }
  return blocks;
}

TEST(RigMovement, OfDepthsIsThatOfTheAxisThatExplainsMoreOfThePixels) {
  const RigParameters theta = testing::world_calibration().theta;
  const RigParameters slope = depth_slope(theta, 90.0).cwiseProduct(plausible_error(theta.tail<3>().norm()));
  const double rms = std::sqrt(10.0 / 9.0);  // ± 1 in ten frames, one of which the mean takes
  const DepthMovement turns = depth_movement_of(alternating(2.0, 1.0, {1.0, 1.0}), theta, 90.0);
  EXPECT_EQ(turns.axis, 1);
  EXPECT_NEAR(turns.share.size, 2.0 * rms * slope.head<3>().norm(), 1e-6);
  EXPECT_NEAR(turns.share.high, turns.share.low, 1e-6);
  const DepthMovement stretches = depth_movement_of(alternating(2.0, 1.0, {1.0, 9.0}), theta, 90.0);
  EXPECT_EQ(stretches.axis, 3);
  EXPECT_NEAR(stretches.share.size, rms * slope.tail<3>().norm(), 1e-4);
  // What explains as much: either.
  const DepthMovement either = depth_movement_of(alternating(2.0, 1.0, {1.0, 4.0}), theta, 90.0);
  EXPECT_NEAR(either.share.low, rms * slope.tail<3>().norm(), 1e-4);
  EXPECT_NEAR(either.share.high, 2.0 * rms * slope.head<3>().norm(), 1e-4);
}

TEST(RigMovement, OfDepthsIsSaidToBeVergenceWhereTheLengthDoesNotCertainlyExplainMore) {
  const RigParameters theta = testing::world_calibration().theta;
  std::vector<DepthHalves> blocks = alternating(2.0, 1.0, {1.0, 2.3});
  const std::vector<DepthHalves> others = alternating(0.5, 1.0, {1.0, 2.3});
  blocks.insert(blocks.end(), others.begin(), others.end());  // 2.1 and 2.3 on average, 0.25 to 4 by block
  EXPECT_EQ(depth_movement_of(blocks, theta, 90.0).axis, 1);
  EXPECT_EQ(depth_movement_of(alternating(1.45, 1.0, {1.0, 2.3}), theta, 90.0).axis, 3);
}

TEST(RigMovement, IsUnknownOfTooFewFrames) {
  const RigMovement none = movement_of(std::vector<FrameHalves>(5), 1);
  EXPECT_EQ(none.px.high, std::numeric_limits<double>::infinity());
}

/// Twice the same errors, without noise: the covariance of those errors, exactly.
TEST(RigMovement, IsTheSpreadOfWhatBothHalvesSay) {
  std::vector<FrameHalves> blocks(4);
  for (std::size_t n = 0; n < 40; ++n) {
    const NormalEquations::Vector beta =
        NormalEquations::Vector::Unit(0) * (n % 2 == 0 ? 3.0 : -1.0);  // 1 ± 2
    blocks[n / 10].add(0.25 * NormalEquations::Matrix::Identity(), beta, beta);
  }
  const RigMovement found = movement_of(blocks, 1);
  EXPECT_NEAR(found.px.size, 0.5 * 2.0, 1e-12);
  EXPECT_NEAR(found.px.low, found.px.high, 1e-12);
  EXPECT_EQ(found.axis, 0);
}

/// Far points say little of a baseline's direction, near ones much, and are worth as much more.
TEST(RigMovement, IsInThePixelsOfTheFrameThatSaysIt) {
  std::vector<FrameHalves> blocks(4);
  for (std::size_t n = 0; n < 40; ++n) {
    const bool far = n % 4 < 2;
    const NormalEquations::Vector beta =
        NormalEquations::Vector::Unit(4) * (far ? 3.0 : 0.003) * (n % 2 == 0 ? 1.0 : -1.0);
    blocks[n / 10].add((far ? 0.01 : 10.0) * NormalEquations::Matrix::Identity(), beta, beta);
  }
  const RigMovement found = movement_of(blocks, 1);
  EXPECT_NEAR(found.px.size, std::sqrt(0.5 * 0.01) * 3.0, 1e-2);  // not sqrt(5) * 3 / sqrt(2)
  EXPECT_EQ(found.axis, 4);
}

}  // namespace
}  // namespace limber
