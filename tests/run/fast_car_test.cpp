// SPDX-License-Identifier: MIT
// A car at 14 m/s with images alone: what the left camera sees before the right one does.
#include <gtest/gtest.h>

#include <string>

#include "limber/diagnose/run_summary.hpp"
#include "limber/run/run_recording.hpp"
#include "limber/simulate/scenario_file.hpp"
#include "limber/simulate/simulator.hpp"

namespace limber {
namespace {

/// White pixels. @param missing  share of right pixels that are
Recording fast_car(double missing, std::uint64_t seed) {
  return simulate(parse_scenario(R"(
name: car
duration: 12
use_imu: false
rates: {stereo: 10}
trajectory: {kind: figure_eight, half_length: 120, min_speed: 12, max_speed: 15, tilt: 1, height: 0.5}
world: {points: 350, placement: in_view, min_distance: 3, max_distance: 50, max_range: 75}
rig:
  theta: [0, 0, 0, -0.35, 0, 0]
  T_imu_cam0: [0, 0, 1, 0.3, -1, 0, 0, 0.1, 0, -1, 0, 0.1, 0, 0, 0, 1]
  cam0: {resolution: [1242, 375], intrinsics: [720, 720, 621, 187.5]}
  cam1: {resolution: [1242, 375], intrinsics: [720, 720, 621, 187.5]}
decalibration: []
noise: {pixel: 0.15, stated: false}
dropout: {right_detections: )" + std::to_string(missing) +
                                     "}",
                                 "car.yaml"),
                  seed);
}

RunSummary summary_of(const Recording& recording, Method method) {
  RunOptions options;
  options.method = method;
  return summarize(recording, options, run_recording(recording, options, matched_frames(recording)));
}

/// Every tenth point began at a depth of 10 ± 50 m in place of 3 to 50, and a linear update took the motion
/// along: 1 to 5 m off, ANEES 31 to 1500, verdict ok.
TEST(FastCar, IsNotMisledByPointsThatTheLeftCameraSeesFirst) {
  for (const Method method : {Method::kEkf, Method::kLcekf}) {
    for (const std::uint64_t seed : {2U}) {
      const RunSummary all = summary_of(fast_car(0.0, seed), method);
      const RunSummary some = summary_of(fast_car(0.1, seed), method);
      EXPECT_LT(some.ate_se3_m.value(), 2.0 * all.ate_se3_m.value() + 0.03) << to_string(method) << seed;
      EXPECT_LT(some.anees.value(), 2.5) << to_string(method) << ' ' << seed;
    }
  }
}

}  // namespace
}  // namespace limber
