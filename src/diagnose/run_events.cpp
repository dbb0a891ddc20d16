// SPDX-License-Identifier: MIT
#include "diagnose/run_events.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <utility>

#include "limber/core/time.hpp"

namespace limber::detail {

void add_event(RunEvent event, const RunRecord& record, InputSummary& inputs) {
  event.frames = static_cast<std::size_t>(std::ranges::count_if(record.frames, [&](const FrameReport& frame) {
    return event.from_ns <= frame.t_ns && frame.t_ns <= event.to_ns;
  }));
  inputs.events.push_back(std::move(event));
  std::ranges::stable_sort(inputs.events, {}, &RunEvent::from_ns);
}

void lose(std::int64_t since_ns, const std::string& why, RunRecord& record, InputSummary& inputs) {
  inputs.lost_since_ns = since_ns;
  record.notes.push_back(fmt::format("the run is lost since {:.3f} s: {}", to_seconds(since_ns), why));
}

}  // namespace limber::detail
