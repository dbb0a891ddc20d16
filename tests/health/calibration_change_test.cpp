// SPDX-License-Identifier: MIT
#include "limber/health/calibration_change.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "health/stereo_world.hpp"

namespace limber {
namespace {

using enum HealthVerdict;
using testing::fly_past;
using testing::World;
using testing::WorldOptions;

constexpr double kDegrees = std::numbers::pi / 180.0;

RigParameters about(Eigen::Index axis, double degrees) {
  return degrees * kDegrees * RigParameters::Unit(axis);
}

RigRecord record_of(std::uint64_t seed, const RigParameters& error,
                    const RigParameters& assumed_off = RigParameters::Zero()) {
  WorldOptions options;
  options.seed = seed;
  options.seconds = 12.0;
  options.points = 40;
  options.error = [=](double) { return error; };
  World world = fly_past(options);
  world.assumed.theta += assumed_off;
  CalibrationWatch watch({}, world.assumed, true);
  for (std::size_t k = 0; k < world.frames.size(); ++k) {
    watch.add(world.frames[k], world.poses[k], {});
  }
  return rig_record(watch.report()->state, world.assumed.theta, true);
}

TEST(ChangeBetween, OfOneRigIsNone) {
  const CalibrationState change =
      change_between(record_of(1, about(1, 0.0)), record_of(2, about(1, 0.0)), {});
  EXPECT_EQ(change.verdict, kOk);
  EXPECT_FALSE(change.named.has_value());
}

TEST(ChangeBetween, SaysWhatTheTransportDid) {
  const RigRecord before = record_of(1, about(0, -0.2)), now = record_of(2, about(0, 0.2));
  const CalibrationState change = change_between(before, now, {});
  EXPECT_EQ(change.verdict, kDecalibrated);
  EXPECT_EQ(change.named, 0u);
  EXPECT_NEAR(change.estimate.delta(0), 0.4 * kDegrees, 3.0 * change.estimate.sigma()(0));
  EXPECT_NEAR(change_between(now, before, {}).estimate.delta(0), -change.estimate.delta(0), 1e-3 * kDegrees);
}

/// Wrong in both by as much: the calibration is off, but nothing moved. Also where it was another calibration
/// that was off each time.
TEST(ChangeBetween, CountsWhatTheRigDidNotWhatWasAssumed) {
  EXPECT_EQ(change_between(record_of(1, about(0, 0.4)), record_of(2, about(0, 0.4)), {}).verdict, kOk);
  const RigRecord recalibrated = record_of(2, about(0, 0.0), about(0, 0.3));
  EXPECT_NEAR(recalibrated.estimate.rig(recalibrated.theta).delta(0), -0.3 * kDegrees, 0.05 * kDegrees);
  const CalibrationState change = change_between(record_of(1, about(0, 0.0)), recalibrated, {});
  EXPECT_EQ(change.verdict, kOk);
  EXPECT_NEAR(change.estimate.delta(0), 0.0, 3.0 * change.estimate.sigma()(0));
}

TEST(ChangeBetween, OfTooFewTracksCannotBeTold) {
  RigRecord few = record_of(1, about(0, 0.0));
  few.tracks = 5;
  EXPECT_EQ(change_between(few, record_of(2, about(0, 0.4)), {}).verdict, kCannotTell);
}

}  // namespace
}  // namespace limber
