// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "limber/measure/rig.hpp"
#include "limber/sensors/samples.hpp"
#include "limber/state/state.hpp"

/// Observations, sorted by point.
namespace limber::detail {

/// One camera's pixel of a point.
struct Sight {
  std::size_t frame = 0;
  int camera = 0;
  Eigen::Vector2d uv;
  bool refused = false;
  double distance = 0.0;  ///< squared, whitened, after the last solution
};

/// A point and all its pixels, in order of time. Its anchor is the first frame whose left camera saw it.
struct Track {
  std::size_t anchor = 0;  ///< frame
  Landmark landmark;       ///< inverse depth
  std::vector<Sight> sights;

  [[nodiscard]] std::size_t used() const;  ///< pixels that were not refused
  [[nodiscard]] Eigen::Vector2d first_left() const;
};

/// @brief All points that can say something: seen by the left camera, and at least twice in all.
/// @param forget_after_s  a track that was away for longer is another point
/// @param lone_frames     keep points that only one frame saw: they say something of the rig
[[nodiscard]] std::vector<Track> gather_tracks(std::span<const StereoFrame> frames, const MountedRig& rig,
                                               double forget_after_s, bool lone_frames);

/// @brief Inverse depth by linear least squares over all pixels, with the poses as they are; those of the
/// right camera are left out where the left one alone has moved far enough.
/// @param trust_rig  the right camera always counts
void triangulate(Track& track, std::span<const Pose> T_world_body, const MountedRig& rig, bool trust_rig);

}  // namespace limber::detail
