// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "limber/diagnose/run_summary.hpp"
#include "limber/navigate/frame_report.hpp"
#include "limber/run/run_recording.hpp"

namespace limber {

/// @brief Since when most points contradict the filter for long [ns]: in more than half of the frames of
/// three seconds its gate was overruled, which would have refused most of what is seen.
/// @return the first such frame of the first such seconds; nothing where there are none
/// @note docs/faults.md
[[nodiscard]] std::optional<std::int64_t> overruled_since(std::span<const FrameReport> frames);

/// @brief Calls a run lost since then, in lost_since_ns and a note. Not with odometry, which carries the
/// state whatever points say, nor where the run is lost already.
void add_overruled(RunRecord& record, RunSummary& summary);

}  // namespace limber
