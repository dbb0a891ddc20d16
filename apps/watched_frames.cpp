// SPDX-License-Identifier: MIT
#include "watched_frames.hpp"

#include <utility>

#include "limber/diagnose/judge_run.hpp"

namespace limber::app {

WatchedFrames::WatchedFrames(const Recording& recording, const RunOptions& options, const ImageFrames& source,
                             FirstFrames::Say say)
    : recording_(recording),
      options_(options),
      source_(source),
      first_(recording, corrected(recording.calibration, options.assume_error), options.gravity,
             source.frames, std::move(say)),
      readout_(corrected(recording.calibration, options.assume_error)) {}

FrameSource WatchedFrames::frames() {
  return [this](std::size_t n) {
    StereoFrame frame = first_(n);
    readout_.add(frame);
    return frame;
  };
}

void WatchedFrames::complete(RunRecord& record) {
  first_.finish(&record);
  record.notes.insert(record.notes.end(), first_.mistakes().begin(), first_.mistakes().end());
  if (source_.record) {
    add_frontend(*source_.record, record);
  }
  add_damaged(source_, record);
}

RunSummary WatchedFrames::judge(RunRecord& record) const {
  RunSummary out = judge_run(recording_, options_, readout_.estimate(), record);
  SensorOffsets offsets = first_.offsets();
  if (first_.gross().empty() && !out.readout_contradicted && !out.inputs.lost_since_ns) {
    offsets.inertial = check_inertial(recording_, options_, record);
    if (const auto mistake = inertial_mistake(offsets)) {
      record.notes.push_back(FirstFrames::in_words(mistake->words));
    }
  }
  add_offsets(offsets, out);
  out.mistakes = first_.gross();
  return out;
}

}  // namespace limber::app
