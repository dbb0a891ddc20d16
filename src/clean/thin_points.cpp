// SPDX-License-Identifier: MIT
#include "clean/thin_points.hpp"

#include <vector>

#include "limber/sensors/spread_points.hpp"

namespace limber::detail {

PointThinner::PointThinner(const StereoCalibration& assumed, std::size_t most)
    : assumed_(assumed), most_(most) {}

std::size_t PointThinner::thin(StereoFrame& frame) {
  const std::size_t given = frame.observations.size();
  if (given > most_) {
    std::vector<PointRank> ranks;
    for (const StereoObservation& point : frame.observations) {
      ranks.push_back({kept_.contains(point.track_id) ? 0 : 1, 0});
    }
    frame = points_at(frame, spread_points(frame, assumed_, most_, ranks));
  }
  kept_.clear();
  for (const StereoObservation& point : frame.observations) {
    kept_.insert(point.track_id);
  }
  return given - frame.observations.size();
}

}  // namespace limber::detail
