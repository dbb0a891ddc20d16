// SPDX-License-Identifier: MIT
#pragma once

#include "limber/measure/rig.hpp"

namespace limber::testing {

/// A camera of 100 px focal length at the body's origin.
inline MountedCamera pinhole_at_the_body() {
  MountedCamera out;
  out.camera = {100.0, 100.0, 320.0, 240.0, 640, 480, NoDistortion{}};
  return out;
}

}  // namespace limber::testing
