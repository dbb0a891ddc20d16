// SPDX-License-Identifier: MIT
// An IMU's clock that steps against that of the cameras.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>

#include "limber/core/time.hpp"
#include "limber/navigate/navigator.hpp"
#include "navigate/scene.hpp"
#include "predict/navigation_error.hpp"

namespace limber {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using testing::kMs;
using testing::make_scene;
using testing::Scene;
using testing::SceneOptions;
using testing::with_method;

constexpr std::int64_t kStepsAt = 4000 * kMs;

Scene swaying(double seconds) {
  SceneOptions options;
  options.duration_s = seconds;
  options.seed = 3;
  return make_scene(options);
}

/// Gives a navigator samples whose stamps step by that much, as far as it wants them.
class LateFeeder {
 public:
  LateFeeder(const Scene& scene, Method method, std::int64_t step_ns)
      : navigator(with_method(scene, method), scene.calibration, scene.initial),
        scene_(scene),
        step_ns_(step_ns) {}

  FrameReport process(const StereoFrame& frame) {
    while (next_ < scene_.inputs.size() && given_ns_ < frame.t_ns + navigator.clock_offset_ns()) {
      const InputSample& sample = scene_.inputs[next_++];
      const std::int64_t stamp_ns = sample.t_ns + (sample.t_ns >= kStepsAt ? step_ns_ : 0);
      if (stamp_ns > given_ns_) {
        given_ns_ = stamp_ns;
        navigator.add_imu({stamp_ns, sample.angular, sample.linear});
      }
    }
    return navigator.process(frame);
  }

  Navigator navigator;

 private:
  const Scene& scene_;
  std::int64_t step_ns_, given_ns_ = -1;
  std::size_t next_ = 0;
};

/// What a run made of a step of the clock.
struct Found {
  std::int64_t offset_ns = 0;
  std::int64_t said_ns = 0;  ///< in the last report of one
  std::optional<std::int64_t> first_ns;
  double last_error = 0.0;  ///< [m]
};

Found run_with_step(const Scene& scene, Method method, std::int64_t step_ns) {
  LateFeeder feeder(scene, method, step_ns);
  Found out;
  for (const StereoFrame& frame : scene.frames) {
    if (frame.t_ns + std::abs(step_ns) > scene.inputs.back().t_ns) {
      break;
    }
    const FrameReport report = feeder.process(frame);
    if (report.inputs.contradiction && report.inputs.contradiction->clock_offset_ns) {
      out.said_ns = *report.inputs.contradiction->clock_offset_ns;
      out.first_ns = out.first_ns.value_or(frame.t_ns);
    }
    const auto k = static_cast<std::size_t>(&frame - scene.frames.data());
    out.last_error =
        (feeder.navigator.estimate().nav().T_world_body.p - scene.truth[k].T_world_body.p).norm();
  }
  out.offset_ns = feeder.navigator.clock_offset_ns();
  return out;
}

/// The noise of the scene's gyroscope is as large as what its rate changes by within a frame: it takes a
/// while.
TEST(ClockStep, IsFoundAndCorrected) {
  const Scene scene = swaying(16.0);
  for (const Method method : {Method::kLcekf, Method::kEkf, Method::kAdaptive}) {
    for (const std::int64_t step_ns : {60 * kMs, -40 * kMs}) {
      const Found found = run_with_step(scene, method, step_ns);
      const std::string which = to_string(method) + " " + std::to_string(step_ns);
      ASSERT_TRUE(found.first_ns) << which;
      EXPECT_GT(*found.first_ns, kStepsAt) << which;
      EXPECT_LT(seconds_between(kStepsAt, *found.first_ns), 6.0) << which;
      EXPECT_LE(std::abs(found.offset_ns - step_ns), std::abs(step_ns) / 4) << which;
      EXPECT_EQ(found.said_ns, found.offset_ns) << which;
      EXPECT_LE(found.last_error, 0.05) << which;
    }
  }
}

TEST(ClockStep, IsNotFoundWhereThereIsNone) {
  const Scene scene = swaying(10.0);
  for (const Method method : {Method::kLcekf, Method::kEkf, Method::kAdaptive}) {
    const Found found = run_with_step(scene, method, 0);
    EXPECT_FALSE(found.first_ns) << to_string(method);
    EXPECT_EQ(found.offset_ns, 0) << to_string(method);
  }
}

/// A start that knows its clock to some hundredths of a second: it is found as well as a step is, whichever
/// size, and not taken for a step that somebody has to know of unless it is large.
TEST(ClockOpenFromTheStart, IsEstimatedUntilItIsKnown) {
  for (const std::int64_t offset_ns : {30 * kMs, -20 * kMs, 0 * kMs}) {
    Scene scene = swaying(12.0);
    for (InputSample& sample : scene.inputs) {
      sample.t_ns += offset_ns;
    }
    scene.initial.clock_sigma = 0.03;
    scene.initial.by_clock = VectorXd::Zero(scene.initial.body_covariance.rows());
    for (const Method method : {Method::kLcekf, Method::kEkf, Method::kAdaptive}) {
      Navigator navigator(with_method(scene, method), scene.calibration, scene.initial);
      for (const InputSample& sample : scene.inputs) {
        navigator.add_imu({sample.t_ns, sample.angular, sample.linear});
      }
      for (const StereoFrame& frame : scene.frames) {
        if (frame.t_ns + 40 * kMs < scene.inputs.back().t_ns) {
          (void)navigator.process(frame);
        }
      }
      const Estimate::ClockStep rest = navigator.estimate().clock_step();  // it may still be open
      const double found = to_seconds(navigator.clock_offset_ns()) + rest.mean;
      EXPECT_LE(std::abs(found - to_seconds(offset_ns)),
                std::max(to_seconds(std::abs(offset_ns)) / 4.0, 5e-3))
          << to_string(method) << " " << offset_ns;
    }
  }
}

/// A second of predictions, by samples that were taken `late_s` before their stamps.
StereoFilter predicted(const Scene& scene, double late_s) {
  InitialState initial = scene.initial;
  initial.nav.t_ns = 500 * kMs;
  StereoFilter filter(scene.options, scene.calibration, initial);
  for (const InputSample& sample : scene.inputs) {
    filter.add_imu({sample.t_ns - std::llround(1e9 * late_s), sample.angular, sample.linear});
  }
  filter.predict_to(1500 * kMs);
  return filter;
}

/// What is carried along for a unit of the step, beside central differences of predictions. That it is
/// smoothed makes it late by some hundredths of a second.
TEST(ClockStep, MovesThePredictionAsLateSamplesDo) {
  SceneOptions options;
  options.noise = false;
  const Scene scene = make_scene(options);
  const StereoFilter filter = predicted(scene, 0.0);
  const Estimate& estimate = filter.estimate();
  const Index clock = estimate.layout().clock_step();
  const VectorXd carried = estimate.P().block(0, clock, 15, 1) / estimate.P().block(clock, clock, 1, 1)(0);
  constexpr double kStep = 1e-4;  // [s]
  const VectorXd expected =
      testing::error_between(predicted(scene, kStep).estimate().nav(),
                             predicted(scene, -kStep).estimate().nav(), MotionModel::kImu) /
      (2.0 * kStep);
  EXPECT_GT(expected.norm(), 0.1);
  EXPECT_LE((carried - expected).norm(), 0.05 * expected.norm()) << carried << "\n\n" << expected;
}

}  // namespace
}  // namespace limber
