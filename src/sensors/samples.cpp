// SPDX-License-Identifier: MIT
#include "limber/sensors/samples.hpp"

#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace limber {

namespace {

constexpr double kFarthest = 1e6;  // [px] from the origin of the image: no lens draws a point there

void check_pixel(const StereoFrame& frame, std::int64_t track_id, const Eigen::Vector2d& uv) {
  if (!(uv.cwiseAbs().array() <= kFarthest).all()) {
    std::ostringstream message;
    message << "frame at " << frame.t_ns << " ns has a pixel that is "
            << (uv.allFinite() ? "out of reach" : "not finite") << ", (" << uv.x() << ", " << uv.y()
            << "), expected one within a million pixels, track " << track_id;
    throw std::invalid_argument(message.str());
  }
}

}  // namespace

void check_points(const StereoFrame& frame) {
  for (const StereoObservation& o : frame.observations) {
    if (o.in_cam0) {
      check_pixel(frame, o.track_id, o.uv_cam0);
    }
    if (o.in_cam1) {
      check_pixel(frame, o.track_id, o.uv_cam1);
    }
  }
}

void remove_tracks(StereoFrame& frame, const std::unordered_set<std::int64_t>& tracks) {
  if (!tracks.empty()) {
    std::erase_if(frame.observations,
                  [&](const StereoObservation& point) { return tracks.contains(point.track_id); });
  }
}

void withdraw_from(std::vector<StereoFrame>& earlier, const StereoFrame& frame) {
  if (frame.withdrawn.empty()) {
    return;
  }
  const std::unordered_set<std::int64_t> tracks(frame.withdrawn.begin(), frame.withdrawn.end());
  for (StereoFrame& before : earlier) {
    remove_tracks(before, tracks);
  }
}

}  // namespace limber
