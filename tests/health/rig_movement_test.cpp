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

/// Roll that swings at 3.3 Hz, by so many degrees.
WorldOptions vibrating(unsigned seed, double degrees) {
  WorldOptions options = realistic(seed);
  options.error = [=](double t) {
    return RigParameters(degrees * kHalfTurn / 180.0 * std::sin(2.0 * kHalfTurn * 3.3 * t) *
                         RigParameters::Unit(2));
  };
  return options;
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

TEST(RigMovement, IsUnknownOfTooFewFrames) {
  const RigMovement none = movement_of(std::vector<FrameHalves>(5), NormalEquations::Matrix::Identity());
  EXPECT_EQ(none.px.high, std::numeric_limits<double>::infinity());
}

/// Twice the same errors, without noise: the covariance of those errors, exactly.
TEST(RigMovement, IsTheSpreadOfWhatBothHalvesSay) {
  std::vector<FrameHalves> blocks(4);
  for (std::size_t n = 0; n < 40; ++n) {
    const NormalEquations::Vector beta =
        NormalEquations::Vector::Unit(0) * (n % 2 == 0 ? 3.0 : -1.0);  // 1 ± 2
    blocks[n / 10].add(beta, beta);
  }
  const RigMovement found = movement_of(blocks, 0.25 * NormalEquations::Matrix::Identity());
  EXPECT_NEAR(found.px.size, 0.5 * 2.0, 1e-12);
  EXPECT_NEAR(found.px.low, found.px.high, 1e-12);
  EXPECT_EQ(found.axis, 0);
}

}  // namespace
}  // namespace limber
