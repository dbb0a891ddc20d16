// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "limber/diagnose/health_summary.hpp"
#include "limber/diagnose/run_summary.hpp"
#include "limber/navigate/frame_report.hpp"
#include "limber/run/run_options.hpp"
#include "limber/run/run_recording.hpp"

namespace limber {

/// @brief Since when something else than the rig has led a filter astray that trusts the rig [ns]: within
/// two seconds its innovations grow to six times their usual size in squares, or so does the share of points
/// that are refused; it stays so for three seconds, at half of that for most of the time that follows, and
/// the rig, by its stereo points alone, neither is wrong nor changed.
/// @return nothing where nothing grows, the rig explains it or nobody judged the rig
/// @note docs/faults.md
[[nodiscard]] std::optional<std::int64_t> misled_since(std::span<const FrameReport> frames,
                                                       const std::optional<HealthSummary>& rig);

/// @brief Calls a run with an IMU lost, in lost_since_ns, an event and a note: `ekf` since it was misled
/// ("misled"), all that trust the rig since steps of the biases that they found late (the same), any method
/// since a bias is impossible ("impossible bias") or moved further than its sigmas allow ("bias moved").
/// Where the rig is wrong, which may move a bias as well, nobody judged it, or biases move all along, the
/// last is said, but the run is not lost for it. A run without an IMU is lost since points that contradicted
/// its state moved it by more than its sigmas allow ("leapt"). Does nothing where it is lost already.
/// `ekf` whose trajectory agrees with that of `lcekf` (agrees_with_lcekf) was not misled: things that move
/// make points contradict each other, too.
void add_misled(const Recording& recording, const RunOptions& options, RunRecord& record,
                RunSummary& summary);

}  // namespace limber
