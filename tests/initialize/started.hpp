// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

#include "limber/initialize/sensor_start.hpp"
#include "navigate/scene.hpp"

/// A start over the frames of a scene.
namespace limber::testing {

struct Started {
  StartReport report;
  SensorStartResult result;
  std::size_t frames = 0;
};

inline NavigatorOptions options_of(const Scene& scene, Method method) {
  NavigatorOptions options = scene.options;
  options.method = method;
  options.constraints.kind = ConstraintSet::Kind::kFull;
  return options;
}

inline Started start(const Scene& scene, const NavigatorOptions& options, const StartOptions& how = {}) {
  SensorStart start(options, scene.calibration, how);
  for (const InputSample& sample : scene.inputs) {
    if (options.motion == MotionModel::kImu) {
      start.add_imu({sample.t_ns, sample.angular, sample.linear});
    }
  }
  Started out;
  for (const StereoFrame& frame : scene.frames) {
    out.report = start.add_frame(frame);
    ++out.frames;
    if (out.report.status != StartStatus::kWaiting) {
      break;
    }
  }
  out.result = start.result();
  return out;
}

/// Scenes are short: as soon as the scale is known to a twentieth.
inline StartOptions at_once() {
  StartOptions how;
  how.open_scale_sigma = 0.05;
  how.longest_fine_s = 0.0;
  return how;
}

inline SceneOptions of_seed(std::uint64_t seed) {
  SceneOptions options;
  options.seed = seed;
  return options;
}

}  // namespace limber::testing
