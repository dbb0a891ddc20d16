// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "limber/core/time.hpp"
#include "limber/navigate/navigator.hpp"
#include "scene.hpp"

namespace limber {
namespace {

using testing::make_scene;
using testing::Scene;
using testing::SceneOptions;
using testing::with_method;

/// Gives a navigator the inputs up to then, from the one that is next.
void add_inputs(const Scene& scene, std::int64_t until_ns, std::size_t& next, Navigator& navigator) {
  for (; next < scene.inputs.size() && scene.inputs[next].t_ns <= until_ns; ++next) {
    navigator.add_imu({scene.inputs[next].t_ns, scene.inputs[next].angular, scene.inputs[next].linear});
  }
}

/// Going back replays some seconds: a robot at 20 Hz stalled for as long as fifty frames take.
TEST(GoingBack, ReplaysAFewFramesACall) {
  SceneOptions scene_options;
  scene_options.duration_s = 12.0;
  scene_options.theta_error = [](double t) {
    return t < 6.0 ? RigParameters(RigParameters::Zero()) : testing::scene_theta_error();
  };
  const Scene scene = make_scene(scene_options);
  Navigator navigator(with_method(scene, Method::kAdaptive), scene.calibration, scene.initial);
  // While it goes back, the parallel filter answers; before that in the frame that the next one confirms.
  const auto goes_back = [&] { return navigator.estimate().layout().has_witness; };
  std::size_t next = 0, calls = 0, most_to_replay = 0;
  bool is_confirmed = false;
  for (const StereoFrame& frame : scene.frames) {
    const bool went_back = goes_back() && is_confirmed;
    is_confirmed = goes_back();
    const std::size_t kept = navigator.events_kept(), first = next;
    add_inputs(scene, frame.t_ns, next, navigator);
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

/// Mismatches beside each other look like a rig that leapt by more than its baseline. To go back in doubt of
/// as much let everything pass, and theta went off by a hundred degrees. Of a rig that is trusted two frames
/// say so, one that confirms the other; of one in doubt a frame alone.
TEST(GoingBack, IsNotForWhatNoRigDoes) {
  for (const bool in_doubt : {false, true}) {
    SCOPED_TRACE(in_doubt);
    SceneOptions scene_options;
    scene_options.duration_s = 12.0;
    const double baseline = make_scene(scene_options).calibration.baseline();
    const auto is_odd = [=](double t) { return t > 9.99 && t < (in_doubt ? 10.01 : 10.06); };
    scene_options.theta_error = [&](double t) {
      RigParameters out = in_doubt && t > 4.0 ? testing::scene_theta_error() : RigParameters::Zero().eval();
      out(4) += is_odd(t) ? 1.5 * baseline : 0.0;
      return out;
    };
    const Scene scene = make_scene(scene_options);
    Navigator navigator(with_method(scene, Method::kAdaptive), scene.calibration, scene.initial);
    const auto goes_back = [&] { return navigator.estimate().layout().has_witness; };
    std::size_t next = 0, odd = 0;
    double sigma = 0.0;
    for (const StereoFrame& frame : scene.frames) {
      const double t = seconds_between(0, frame.t_ns);
      add_inputs(scene, frame.t_ns, next, navigator);
      if (t > 9.94 && t < 9.96) {
        ASSERT_FALSE(goes_back()) << "it has caught up since the step";
        sigma = navigator.calibration_estimate().sigma(4);
      }
      (void)navigator.process(frame);
      if (is_odd(t) && ++odd == 1 && in_doubt) {
        EXPECT_LT(navigator.calibration_estimate().sigma(4), std::max(3.0 * sigma, 0.1 * baseline));
      }
      EXPECT_FALSE(t > 10.04 && goes_back()) << t;
    }
    EXPECT_EQ(odd, in_doubt ? 1U : 2U);
  }
}

/// The filter that answers is lost, the one beside is not: its state goes on.
TEST(GoingBack, IsNotForAFilterThatBeginsAnew) {
  for (const bool in_doubt : {false, true}) {
    SceneOptions scene_options;
    scene_options.duration_s = 12.0;
    scene_options.theta_error = [&](double t) {
      return in_doubt && t > 4.0 ? testing::scene_theta_error() : RigParameters(RigParameters::Zero());
    };
    const Scene scene = make_scene(scene_options);
    Navigator navigator(with_method(scene, Method::kAdaptive), scene.calibration, scene.initial);
    std::size_t next = 0;
    for (std::size_t k = 0; k < scene.frames.size(); ++k) {
      const bool is_lost = std::abs(seconds_between(0, scene.frames[k].t_ns) - 10.0) < 0.01;
      if (is_lost) {  // by a covariance that nobody could have made
        auto& estimate = const_cast<Estimate&>(navigator.estimate());
        ASSERT_FALSE(estimate.layout().has_witness) << "it answers itself";
        estimate.mutable_P().set_diagonal_block(0, -1e6 * Eigen::Matrix3d::Identity());
      }
      add_inputs(scene, scene.frames[k].t_ns, next, navigator);
      const FrameReport report = navigator.process(scene.frames[k]);
      EXPECT_FALSE(report.reset) << k;
      EXPECT_TRUE(report.status == UpdateStatus::kUpdated || k == 0) << k;
    }
    const double sigma = std::sqrt(navigator.estimate().P().diagonal_block<3>(0).trace());
    EXPECT_LT(sigma, 0.3);
    EXPECT_LT((navigator.estimate().nav().T_world_body.p - scene.truth.back().T_world_body.p).norm(),
              4.0 * sigma);
    // It does not trust the rig as it was given.
    EXPECT_FALSE(navigator.calibration_estimate().trusts_rig);
  }
}

}  // namespace
}  // namespace limber
