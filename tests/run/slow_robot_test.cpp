// SPDX-License-Identifier: MIT
// A robot that creeps, with an odometer of which nobody states how good it is: depths by its motion are off,
// and so is its body beside the camera.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>

#include "limber/diagnose/run_summary.hpp"
#include "limber/run/run_recording.hpp"
#include "limber/simulate/scenario_file.hpp"
#include "limber/simulate/simulator.hpp"

namespace limber {
namespace {

/// @param keys  beside, of YAML
Recording robot(const std::string& keys, std::uint64_t seed) {
  return simulate(parse_scenario(R"(
name: robot
rates: {stereo: 20}
use_imu: false
odometry: {rate: 50, velocity: 0.04, angular_rate: 0.008}
trajectory: {kind: random_spline, half_extent: [4, 4, 0.8], max_speed: 0.6, max_angular_rate: 0.8, knot_spacing: 4.6,
             max_angles: [9, 9, 180], rest: 1}
world: {points: 200, placement: in_view, min_distance: 1.3, max_distance: 20, min_range: 0.9, max_range: 25}
rig:
  theta: [0.5, -0.5, 0.3, -0.16, 0.002, -0.002]
  T_imu_cam0: [0, 0, 1, 0.1, -1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 0, 1]
decalibration: []
)" + keys,
                                 "robot.yaml"),
                  seed);
}

Recording realistic_robot(std::uint64_t seed) {
  return robot("duration: 12\npixels: realistic\nnoise: {stated: false}", seed);
}

struct RobotRun {
  RunRecord record;
  RunSummary summary;
};

RobotRun run(const Recording& recording, Method method = Method::kLcekf) {
  RunOptions options;
  options.method = method;
  RunRecord record = run_recording(recording, options, matched_frames(recording));
  RunSummary summary = summarize(recording, options, record);
  return {std::move(record), std::move(summary)};
}

/// What lasts in the pixels of landmarks that are sure of their place was taken for another mount: 5.9 of
/// six. @return geometric mean of ANEES
double anees_beside_a_doubted_mount(std::uint64_t first, std::uint64_t last) {
  double product = 1.0;
  for (std::uint64_t seed = first; seed <= last; ++seed) {
    product *= run(realistic_robot(seed), Method::kEkf).summary.anees.value();
  }
  return std::pow(product, 1.0 / static_cast<double>(last - first + 1));
}

TEST(SlowRobot, KnowsHowItsBodyStandsBesideItsCamera) { EXPECT_LT(anees_beside_a_doubted_mount(2, 2), 2.5); }

TEST(FullSlowRobot, KnowsHowItsBodyStandsBesideItsCamera) {
  EXPECT_LT(anees_beside_a_doubted_mount(1, 6), 3.0);
}

/// Mean square of the vergence that is found of a sound rig, over its variance.
double mean_square_of_vergence(std::uint64_t first, std::uint64_t last) {
  double sum = 0.0;
  for (std::uint64_t seed = first; seed <= last; ++seed) {
    const RigEstimate rig = run(realistic_robot(seed)).summary.health.value().present.estimate;
    sum += rig.delta(1) * rig.delta(1) / rig.covariance(1, 1);
  }
  return sum / static_cast<double>(last - first + 1);
}

/// Seen from where the body was, with the mount as given, six had 4.5.
TEST(FullSlowRobot, IsJudgedFromWhereItsCameraWas) {
  const double square = mean_square_of_vergence(1, 12);
  EXPECT_LT(square, 2.2);  // 99 % of chi-square of twelve, over twelve
  EXPECT_GT(square, 0.3);
}

/// A tenth of the points is somewhere else in each frame: what lasts in the others is seen all the same.
TEST(SlowRobot, KnowsWhereItIsBesideMismatches) {
  const RobotRun seen =
      run(robot("duration: 6\nnoise: {stated: false, pixel: 0.14}\n"
                "pixels: {per_track: 0.33, correlated: 0.17, field: 0.05, mismatches: 0.1}",
                1));
  EXPECT_GT(seen.record.pixel_noise.value().correlation, 0.7);
  EXPECT_LT(seen.summary.anees.value(), 2.5);
}

}  // namespace
}  // namespace limber
