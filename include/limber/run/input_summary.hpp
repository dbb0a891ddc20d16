// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "limber/navigate/frame_report.hpp"
#include "limber/run/run_event.hpp"

namespace limber {

/// What a run's frames rested on.
struct InputSummary {
  std::size_t updated = 0, no_points = 0, singular = 0;                                    ///< frames
  std::size_t sound = 0, faulty = 0, gap = 0, contradicted = 0, none = 0, not_needed = 0;  ///< frames
  std::vector<RunEvent> events;  ///< in the order in which they began
  /// From here on the world is not the one of the start: the filter broke down and began anew, or points
  /// contradict it. The first frame where no frame at all was updated: nobody knows how wrong that is.
  std::optional<std::int64_t> lost_since_ns;
};

/// Frames with the same trouble that are less than a second apart are one event.
[[nodiscard]] InputSummary summarize_inputs(const std::vector<FrameReport>& frames);

/// The same in words, a line each; empty if all was well.
[[nodiscard]] std::vector<std::string> remarks_on_inputs(const InputSummary& summary);

}  // namespace limber
