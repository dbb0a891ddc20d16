// SPDX-License-Identifier: MIT
#include <sstream>
#include <stdexcept>
#include <string>

#include "limber/sensors/samples.hpp"

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

}  // namespace limber
