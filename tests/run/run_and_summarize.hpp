// SPDX-License-Identifier: MIT
#pragma once

#include "limber/diagnose/run_summary.hpp"
#include "limber/run/run_recording.hpp"

namespace limber::testing {

/// What a run over the matched points of a recording comes to.
inline RunSummary run_and_summarize(const Recording& recording, const RunOptions& options) {
  return summarize(recording, options, run_recording(recording, options, matched_frames(recording)));
}

}  // namespace limber::testing
