// SPDX-License-Identifier: MIT
#pragma once

#include "limber/run/input_summary.hpp"
#include "limber/run/run_recording.hpp"

namespace limber::detail {

/// Counts the frames of an event and puts it in its place.
void add_event(RunEvent event, const RunRecord& record, InputSummary& inputs);

}  // namespace limber::detail
