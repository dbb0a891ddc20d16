// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>

#include "limber/navigate/navigator.hpp"
#include "scene.hpp"

namespace limber {
namespace {

using testing::make_scene;
using testing::Scene;
using testing::SceneOptions;
using testing::with_method;

/// Going back replays some seconds: a robot at 20 Hz stalled for as long as fifty frames take.
TEST(GoingBack, ReplaysAFewFramesACall) {
  SceneOptions scene_options;
  scene_options.duration_s = 12.0;
  scene_options.theta_error = [](double t) {
    return t < 6.0 ? RigParameters(RigParameters::Zero()) : testing::scene_theta_error();
  };
  const Scene scene = make_scene(scene_options);
  Navigator navigator(with_method(scene, Method::kAdaptive), scene.calibration, scene.initial);
  // While it goes back, the parallel filter answers.
  const auto goes_back = [&] { return navigator.estimate().layout().has_witness; };
  std::size_t next = 0, calls = 0, most_to_replay = 0;
  for (const StereoFrame& frame : scene.frames) {
    const bool went_back = goes_back();
    const std::size_t kept = navigator.events_kept(), first = next;
    for (; next < scene.inputs.size() && scene.inputs[next].t_ns <= frame.t_ns; ++next) {
      navigator.add_imu({scene.inputs[next].t_ns, scene.inputs[next].angular, scene.inputs[next].linear});
    }
    (void)navigator.process(frame);
    EXPECT_EQ(navigator.estimate().nav().t_ns, frame.t_ns);
    if (went_back) {
      const std::size_t of_a_frame = next - first + 1;
      EXPECT_LE(kept + of_a_frame, navigator.events_kept() + 3 * of_a_frame) << frame.t_ns;
      most_to_replay = std::max(most_to_replay, kept);
      ++calls;
    }
  }
  EXPECT_GE(calls, 5U);
  EXPECT_GT(most_to_replay, 10U * 11U) << "ten frames and their samples";
  EXPECT_FALSE(goes_back());
}

}  // namespace
}  // namespace limber
