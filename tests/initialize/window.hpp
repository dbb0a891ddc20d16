// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "limber/core/so3.hpp"
#include "limber/initialize/stereo_motion.hpp"
#include "limber/measure/rig.hpp"
#include "navigate/scene.hpp"

/// The first second of a scene, as a start sees it.
namespace limber::testing {

struct Window {
  Scene scene;
  std::vector<ImuSample> imu;

  [[nodiscard]] std::vector<StampedPose> motion() const {
    return stereo_motion(scene.frames, scene.calibration);
  }
  /// T_first_body of a frame.
  [[nodiscard]] Pose moved(std::size_t frame) const {
    return scene.truth.front().T_world_body.inverse() * scene.truth[frame].T_world_body;
  }
  [[nodiscard]] Eigen::Vector3d v_body() const {
    const NavigationState& first = scene.truth.front();
    return first.T_world_body.R.transpose() * first.v_world_body;
  }
  [[nodiscard]] Eigen::Vector3d gravity_body() const {
    return scene.truth.front().T_world_body.R.transpose() * Eigen::Vector3d(0.0, 0.0, -9.81);
  }
};

inline Window make_window(SceneOptions options) {
  options.duration_s = 1.0;
  Window out{make_scene(options), {}};
  for (const InputSample& sample : out.scene.inputs) {
    out.imu.push_back({sample.t_ns, sample.angular, sample.linear});
  }
  return out;
}

/// A baseline that is truly a tenth longer than assumed.
inline SceneOptions longer_baseline(std::uint64_t seed) {
  SceneOptions options;
  options.seed = seed;
  options.theta_error = [](double) {
    RigParameters error = RigParameters::Zero();
    error.tail<3>() = 0.1 * scene_rig().theta.tail<3>();
    return error;
  };
  return options;
}

}  // namespace limber::testing
