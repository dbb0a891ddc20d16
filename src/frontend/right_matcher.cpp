// SPDX-License-Identifier: MIT
#include "frontend/right_matcher.hpp"

#include <algorithm>

namespace limber::frontend {
namespace {

constexpr int kLongestWait = 8;  ///< [frames] between two searches for the same point

}  // namespace

RightMatcher::RightMatcher(const StereoCalibration& assumed, const TrackerOptions& options)
    : assumed_(assumed), search_(assumed, options), consensus_(options.max_epipolar_px / assumed.cam1.fu) {}

/// Asks again later, and less often from time to time.
void RightMatcher::miss(Memory& memory) {
  memory.matched = false;
  memory.wait = std::min(1 << std::min(memory.failures, 8), kLongestWait);
  ++memory.failures;
}

std::optional<PatchFit> RightMatcher::look_for(const Pyramid& left, SearchedImage& right,
                                               const Eigen::Vector2d& uv0, const Memory& memory,
                                               const std::vector<Change>& changes) const {
  if (memory.matched) {
    PatchFit guess{uv0 + memory.offset, memory.shape};
    const auto nearest =
        std::min_element(changes.begin(), changes.end(), [&](const Change& x, const Change& y) {
          return (x.uv_cam0 - uv0).squaredNorm() < (y.uv_cam0 - uv0).squaredNorm();
        });
    if (nearest != changes.end()) guess.uv += nearest->change;
    if (auto fit = search_.follow(left, right.pyramid(), uv0, guess)) return fit;
  }
  return search_.find(left, right, uv0);
}

void RightMatcher::match(const Pyramid& left, const Pyramid& right, StereoFrame& frame) {
  SearchedImage searched(right);
  std::vector<BearingPair> pairs;
  std::vector<StereoObservation*> owners;
  std::vector<Change> changes;
  std::map<std::int64_t, Memory> memories;  // of the tracks that still live
  for (StereoObservation& point : frame.observations) {
    Memory& memory = memories[point.track_id] = memories_[point.track_id];
    if (memory.wait > 0 && --memory.wait > 0) continue;
    const auto fit = look_for(left, searched, point.uv_cam0, memory, changes);
    const auto bearing0 = unproject(assumed_.cam0, point.uv_cam0);
    const auto bearing1 = fit ? unproject(assumed_.cam1, fit->uv) : std::nullopt;
    if (!bearing0 || !bearing1) {
      miss(memory);
      continue;
    }
    point.uv_cam1 = fit->uv;
    const Eigen::Vector2d offset = fit->uv - point.uv_cam0;
    if (memory.matched) changes.push_back({point.uv_cam0, offset - memory.offset});
    memory.offset = offset;
    memory.shape = fit->A;
    pairs.push_back({*bearing0, *bearing1});
    owners.push_back(&point);
  }
  const std::vector<bool> agrees = consensus_.judge(pairs);
  for (std::size_t k = 0; k < owners.size(); ++k) {
    StereoObservation& point = *owners[k];
    Memory& memory = memories[point.track_id];
    point.in_cam1 = agrees[k];
    if (point.in_cam1) {
      memory.matched = true;
      memory.failures = 0;
    } else {
      point.uv_cam1.setZero();
      miss(memory);  // it led astray: search afresh
    }
  }
  memories_ = std::move(memories);
}

}  // namespace limber::frontend
