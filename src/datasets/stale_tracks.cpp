// SPDX-License-Identifier: MIT
#include "stale_tracks.hpp"

#include <algorithm>
#include <cstdint>
#include <unordered_map>

namespace limber::detail {
namespace {

constexpr std::size_t kFewestEqual = 5;  // points whose equal digits are no chance

using Points = std::unordered_map<std::int64_t, const StereoObservation*>;

Points by_track(const StereoFrame& frame) {
  Points out;
  for (const StereoObservation& point : frame.observations) {
    out[point.track_id] = &point;
  }
  return out;
}

bool same_pixels(const StereoObservation& a, const StereoObservation& b) {
  return a.in_cam0 == b.in_cam0 && a.in_cam1 == b.in_cam1 && a.uv_cam0 == b.uv_cam0 && a.uv_cam1 == b.uv_cam1;
}

/// Every point that both frames hold stands on the same pixels.
bool is_stale(const StereoFrame& frame, const Points& before) {
  std::size_t shared = 0;
  for (const StereoObservation& point : frame.observations) {
    const auto it = before.find(point.track_id);
    if (it != before.end()) {
      if (!same_pixels(point, *it->second)) {
        return false;
      }
      ++shared;
    }
  }
  return shared >= kFewestEqual;
}

std::vector<std::size_t> stale_frames(const std::vector<StereoFrame>& frames) {
  std::vector<std::size_t> out;
  for (std::size_t k = 1; k < frames.size(); ++k) {
    if (is_stale(frames[k], by_track(frames[k - 1]))) {
      out.push_back(k);
    }
  }
  return out;
}

std::int64_t largest_track(const std::vector<StereoFrame>& frames) {
  std::int64_t largest = 0;
  for (const StereoFrame& frame : frames) {
    for (const StereoObservation& point : frame.observations) {
      largest = std::max(largest, point.track_id);
    }
  }
  return largest;
}

}  // namespace

std::size_t cut_stale_tracks(std::vector<StereoFrame>& frames) {
  const std::vector<std::size_t> stale = stale_frames(frames);
  if (stale.empty() || 2 * stale.size() > frames.size()) {
    return 0;
  }
  std::int64_t next_id = largest_track(frames) + 1;
  std::unordered_map<std::int64_t, std::int64_t> renamed;  // as in the file -> as it is called by now
  const auto called = [&](std::int64_t id) {
    const auto it = renamed.find(id);
    return it == renamed.end() ? id : it->second;
  };
  auto next_stale = stale.begin();
  for (std::size_t k = stale.front(); k < frames.size(); ++k) {
    if (next_stale != stale.end() && *next_stale == k) {
      ++next_stale;
      const Points before = by_track(frames[k - 1]);
      std::erase_if(frames[k].observations, [&](const StereoObservation& point) {
        const bool old = before.contains(called(point.track_id));
        if (old) {
          renamed[point.track_id] = next_id++;
        }
        return old;
      });
    }
    for (StereoObservation& point : frames[k].observations) {
      point.track_id = called(point.track_id);
    }
  }
  return stale.size();
}

}  // namespace limber::detail
