// SPDX-License-Identifier: MIT
#include "limber/landmarks/landmark_budget.hpp"

#include <cstdint>
#include <utility>
#include <vector>

#include "limber/sensors/spread_points.hpp"

namespace limber {
namespace {

enum PointGroup : std::uint8_t { kInUse, kKnown, kNew };

PointGroup group_of(const StereoObservation& point, const Estimate& estimate, std::int64_t previous_ns) {
  const Landmark* landmark = estimate.find(point.track_id);
  if (landmark == nullptr) {
    return kNew;
  }
  return landmark->last_seen_ns == previous_ns ? kInUse : kKnown;
}

}  // namespace

LandmarkBudget::LandmarkBudget(const StereoCalibration& assumed, std::size_t most)
    : assumed_(assumed), most_(most) {}

StereoFrame LandmarkBudget::choose(StereoFrame frame, const Estimate& estimate, std::int64_t previous_ns) {
  const auto before = std::exchange(waited_, {});
  const std::vector<StereoObservation>& points = frame.observations;
  if (points.size() <= most_) {
    return frame;
  }
  std::vector<PointRank> ranks;
  for (const StereoObservation& point : points) {
    const auto waited = before.find(point.track_id);
    ranks.push_back({group_of(point, estimate, previous_ns), waited == before.end() ? 0 : -waited->second});
  }
  const std::vector<std::size_t> chosen = spread_points(frame, assumed_, most_, ranks);
  for (std::size_t k = 0, next = 0; k < points.size(); ++k) {
    if (next < chosen.size() && chosen[next] == k) {
      ++next;
    } else {
      waited_[points[k].track_id] = 1 - ranks[k].order;
    }
  }
  return points_at(frame, chosen);
}

}  // namespace limber
