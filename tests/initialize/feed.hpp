// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

#include "limber/initialize/sensor_start.hpp"
#include "navigate/scene.hpp"

/// A scene's samples, as a robot would have them.
namespace limber::testing {

inline StartOptions soon() {
  StartOptions out;
  out.longest_s = out.longest_moving_s = 1.0;
  return out;
}

template <typename Receiver>
void give(Receiver& receiver, MotionModel motion, const InputSample& sample) {
  if (motion == MotionModel::kImu) {
    receiver.add_imu({sample.t_ns, sample.angular, sample.linear});
  } else if (motion == MotionModel::kOdometry) {
    receiver.add_odometry({sample.t_ns, sample.linear, sample.angular});
  }
}

/// Samples of a scene, each once, up to the first at or after the time asked for.
struct Feed {
  template <typename Receiver>
  void until(Receiver& receiver, std::int64_t t_ns) {
    while (next < scene.inputs.size() && (next == 0 || scene.inputs[next - 1].t_ns < t_ns)) {
      give(receiver, scene.options.motion, scene.inputs[next++]);
    }
  }
  const Scene& scene;
  std::size_t next = 0;
};

}  // namespace limber::testing
