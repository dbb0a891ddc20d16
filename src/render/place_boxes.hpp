// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <functional>

#include "limber/render/scene.hpp"

namespace limber::detail {

/// What boxes move around: both cameras of a rig over a recording.
struct Visit {
  std::function<std::array<Pose, 2>(double t)> cameras;  ///< T_world_cam at t [s]
  double duration = 0.0;                                 ///< [s]
};

/// @brief Adds boxes that cross what the left camera sees, each at another part of the recording. They never
/// touch a camera, a wall or each other.
/// @throws std::invalid_argument if there is no room for so many
void add_moving_boxes(Scene& scene, SceneKind kind, int count, const Visit& visit, std::uint64_t seed,
                      std::uint64_t run);

}  // namespace limber::detail
