// SPDX-License-Identifier: MIT
#pragma once

#include <utility>

#include "limber/diagnose/run_summary.hpp"
#include "limber/run/run_recording.hpp"
#include "run/short_recording.hpp"

namespace limber::testing {

/// A recording, a run over it and what is said of the run.
struct Judged {
  explicit Judged(Recording r, StartMode start = StartMode::kGroundTruth, Method method = Method::kLcekf)
      : recording(std::move(r)) {
    options.start = start;
    options.method = method;
    options.seed = 7;
    record = run_recording(recording, options, matched_frames(recording));
    summary = summarize(recording, options, record);
  }
  Recording recording;
  RunOptions options;
  RunRecord record;
  RunSummary summary;
};

inline Recording without_truth() {
  Recording recording = short_recording();
  recording.truth.motion.states.clear();
  return recording;
}

}  // namespace limber::testing
