// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

#include "first_frames.hpp"
#include "frame_source.hpp"
#include "limber/diagnose/readout_watch.hpp"
#include "limber/diagnose/run_summary.hpp"

namespace limber::app {

/// @brief Frames on their way into a run, seen by all that judges it.
class WatchedFrames {
 public:
  /// @param recording, options, source  of the run; must outlive this
  /// @param say  of mistakes in the first frames, as FirstFrames has it
  WatchedFrames(const Recording& recording, const RunOptions& options, const ImageFrames& source,
                FirstFrames::Say say);

  /// For run_recording; must not outlive this.
  [[nodiscard]] FrameSource frames();
  /// Where the run failed: what was wrong with the first frames is said nevertheless.
  void finish() { first_.finish(nullptr); }
  /// Adds to the record what these frames cost, which were damaged and what is wrong with the first.
  void complete(RunRecord& record);
  /// All that a run says of itself, once its record is complete: judge_run, and mistakes.
  /// @param record  gets notes
  [[nodiscard]] RunSummary judge(RunRecord& record) const;

 private:
  const Recording& recording_;
  const RunOptions& options_;
  const ImageFrames& source_;
  FirstFrames first_;
  ReadoutWatch readout_;
};

}  // namespace limber::app
