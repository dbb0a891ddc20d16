// SPDX-License-Identifier: MIT
#include "frontend/picture_order.hpp"

#include <algorithm>

#include "limber/core/time.hpp"

namespace limber::frontend {
namespace {

constexpr int kPairsToKnow = 3;          ///< after so many the order is known
constexpr double kLongestPutBack = 1.0;  ///< [s]
constexpr double kClearlyNearer = 0.8;   ///< of how far points are from where they were to come
constexpr double kClearlySame = 0.8;     ///< of how far depths are from those of exchanged pictures
constexpr double kClearlyTurned = 0.5;   ///< the same, of how far they are from those before
constexpr std::size_t kClearlyMore = 2;  ///< times as many points

/// Blurred pictures in a quick turn go on badly in either order, but their depths go on in the right one
/// alone.
bool depths_go_on(const detail::FrameContinuity& now) { return now.same < kClearlySame * now.opposite; }
bool depths_turn_round(const detail::FrameContinuity& now) {
  return now.opposite < kClearlyTurned * now.same;
}

/// Exchanged pictures lose points rather than move them where the cameras see different things.
bool loses_most(const detail::FrameContinuity& now) { return 2 * now.shared < now.had; }

}  // namespace

bool PictureOrder::doubts(const StereoFrame& as_given) const {
  if (pairs_ < kPairsToKnow ||
      (put_back_since_ && seconds_between(*put_back_since_, as_given.t_ns) > kLongestPutBack)) {
    return false;
  }
  const auto now = pictures_.continuity(as_given);
  return now && (looks_exchanged(*now) || loses_most(*now));
}

bool PictureOrder::prefers(const StereoFrame& put_back, const StereoFrame& as_given) const {
  const auto theirs = pictures_.continuity(as_given), ours = pictures_.continuity(put_back);
  if (!theirs || !ours || ours->shared < detail::kFewestToJudgeOrder || !depths_go_on(*ours)) return false;
  if (theirs->shared < detail::kFewestToJudgeOrder) return ours->shared >= kClearlyMore * theirs->shared;
  if (depths_turn_round(*theirs)) return true;
  return ours->shared >= theirs->shared && ours->off < kClearlyNearer * theirs->off;
}

void PictureOrder::remember(const StereoFrame& taken) {
  pictures_.remember(taken);
  pairs_ = std::min(pairs_ + 1, kPairsToKnow);
  if (!taken.put_back) {
    put_back_since_.reset();
  } else if (!put_back_since_) {
    put_back_since_ = taken.t_ns;
  }
}

}  // namespace limber::frontend
