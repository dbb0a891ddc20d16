// SPDX-License-Identifier: MIT
#include "limber/navigate/moving_tracks.hpp"

namespace limber {

void MovingTracks::leave_out_of(StereoFrame& frame) {
  std::erase_if(until_ns_, [&](const auto& track) { return track.second < frame.t_ns; });
  std::erase_if(frame.observations,
                [&](const StereoObservation& point) { return until_ns_.contains(point.track_id); });
}

void MovingTracks::note(const FrameReport& report) {
  if (!report.most_move) {
    return;
  }
  for (const Refusal& refusal : report.refused) {
    if (refusal.reason == RefusalReason::kGate) {
      until_ns_[refusal.track_id] = report.t_ns + static_cast<std::int64_t>(1e9 * kLeftOut);
    }
  }
}

}  // namespace limber
