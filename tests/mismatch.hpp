// SPDX-License-Identifier: MIT
#pragma once

#include <random>
#include <vector>

#include "limber/sensors/camera.hpp"
#include "limber/sensors/samples.hpp"

namespace limber::testing {

/// Of every point in every frame with this probability: both pixels are anywhere.
template <typename Generator>
void mismatch(std::vector<StereoFrame>& frames, const Camera& camera, double share, Generator random) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const auto anywhere = [&] {
    return Eigen::Vector2d(camera.width * uniform(random), camera.height * uniform(random));
  };
  for (StereoFrame& frame : frames) {
    for (StereoObservation& o : frame.observations) {
      if (uniform(random) < share) {
        o.uv_cam0 = anywhere();
        o.uv_cam1 = anywhere();
      }
    }
  }
}

}  // namespace limber::testing
