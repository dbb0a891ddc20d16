// SPDX-License-Identifier: MIT
#pragma once

#include "scene.hpp"

namespace limber::testing {

/// A second of 40 points.
inline Scene small_scene() {
  SceneOptions options;
  options.duration_s = 1.0;
  options.points = 40;
  return make_scene(options);
}

}  // namespace limber::testing
