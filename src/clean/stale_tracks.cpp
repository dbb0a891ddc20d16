// SPDX-License-Identifier: MIT
#include "clean/stale_tracks.hpp"

#include <vector>

namespace limber::detail {
namespace {

constexpr std::size_t kFewestEqual = 5;  // points whose equal digits are no chance

bool same_pixels(const StereoObservation& a, const StereoObservation& b) {
  return a.in_cam0 == b.in_cam0 && a.in_cam1 == b.in_cam1 && a.uv_cam0 == b.uv_cam0 && a.uv_cam1 == b.uv_cam1;
}

}  // namespace

/// Every point that both frames hold stands on the same pixels.
bool StaleTracks::is_stale(const StereoFrame& frame) const {
  std::size_t shared = 0;
  for (const StereoObservation& point : frame.observations) {
    const auto it = before_.find(point.track_id);
    if (it != before_.end()) {
      if (!same_pixels(point, it->second)) {
        return false;
      }
      ++shared;
    }
  }
  return shared >= kFewestEqual;
}

std::int64_t StaleTracks::called(std::int64_t id) const {
  const auto it = renamed_.find(id);
  return it == renamed_.end() ? id : it->second;
}

std::size_t StaleTracks::end(StereoFrame& frame) {
  const bool stale = is_stale(frame);
  stale_ += stale ? 1 : 0;
  ++frames_;
  std::unordered_map<std::int64_t, StereoObservation> now;
  for (const StereoObservation& point : frame.observations) {
    now.emplace(point.track_id, point);
  }
  std::size_t ended = 0;
  if (stale && 2 * stale_ < frames_) {
    ended = std::erase_if(frame.observations, [&](const StereoObservation& point) {
      const bool old = before_.contains(point.track_id);
      if (old) {
        renamed_[point.track_id] = next_id_--;
      }
      return old;
    });
  }
  for (StereoObservation& point : frame.observations) {
    point.track_id = called(point.track_id);
  }
  before_ = std::move(now);
  return ended;
}

}  // namespace limber::detail
