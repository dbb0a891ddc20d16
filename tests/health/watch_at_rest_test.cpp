// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>

#include "health/stereo_world.hpp"
#include "limber/health/calibration_watch.hpp"

namespace limber {
namespace {

using enum HealthVerdict;
using testing::fly_past;
using testing::World;
using testing::WorldOptions;

/// A rest after a flight: how long a metre is, a camera that stands still does not know, nor does it ask.
TEST(WatchAtRest, ForgetsNoDepth) {
  WorldOptions flight;
  flight.seconds = 15.0;
  const World world = fly_past(flight);
  CalibrationWatch watch({}, world.assumed, true);
  for (std::size_t k = 0; k < world.frames.size(); ++k) {
    watch.add(world.frames[k], world.poses[k], {true, 1.0, 1e-4});
  }
  const double moving = watch.report()->state.effect.depth.high;
  StereoFrame frame = world.frames.back();
  for (int k = 0; k < 600; ++k) {
    frame.t_ns += 50'000'000;
    watch.add(frame, world.poses.back(), {true, 1e-4, 1e-4});
  }
  EXPECT_LT(watch.report()->state.effect.depth.high,
            1.5 * moving);  // 28 times that where rests count as much
  EXPECT_GT(watch.report()->state.windows, 10u);
}

/// Places that images alone tell of a camera that stands still: they tremble, and depths were told by that.
TEST(WatchAtRest, CannotTellByTrembling) {
  WorldOptions options;
  options.seconds = 20.0;
  options.points = 40;
  options.speed = 0.0;
  options.per_track_px = 0.3;
  const World world = fly_past(options);
  CalibrationWatch watch({}, world.assumed, false);
  for (std::size_t k = 0; k < world.frames.size(); ++k) {
    Pose pose = world.poses[k];
    pose.p += 0.02 * Eigen::Vector3d(std::sin(0.9 * static_cast<double>(k)), std::cos(static_cast<double>(k)),
                                     std::sin(0.05 * static_cast<double>(k)));
    watch.add(world.frames[k], pose, {true, 1e-3, 1e-2});
    if (watch.report()) EXPECT_EQ(watch.report()->state.verdict, kCannotTell) << k;
  }
  ASSERT_TRUE(watch.report());
  EXPECT_EQ(watch.report()->state.by_depth, kCannotTell);
  EXPECT_LT(watch.report()->state.effect.epipolar_px.low, 0.3);
}

}  // namespace
}  // namespace limber
