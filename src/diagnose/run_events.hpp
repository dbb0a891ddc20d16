// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

#include "limber/run/input_summary.hpp"
#include "limber/run/run_recording.hpp"

namespace limber::detail {

/// Counts the frames of an event and puts it in its place.
void add_event(RunEvent event, const RunRecord& record, InputSummary& inputs);

/// The run is lost since then, and a note says why.
void lose(std::int64_t since_ns, const std::string& why, RunRecord& record, InputSummary& inputs);

}  // namespace limber::detail
