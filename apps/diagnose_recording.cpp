// SPDX-License-Identifier: MIT
#include "diagnose_recording.hpp"

#include <exception>
#include <vector>

#include "limber/diagnose/calibration_mistakes.hpp"

namespace limber::app {

Diagnosis diagnose_recording(const Recording& recording, const RunOptions& options, const FrameSource& frames,
                             const std::function<void(std::size_t)>& progress,
                             const std::function<void(const RunRecord&, const RunSummary&)>& done) {
  Diagnosis out;
  out.dataset = recording.name;
  out.false_alarms_per_hour = options.false_alarms_per_hour;
  const StereoCalibration assumed = corrected(recording.calibration, options.assume_error);
  std::vector<StereoFrame> seen;
  const FrameSource remembered = [&](std::size_t n) {
    seen.push_back(frames(n));
    return seen.back();
  };
  try {
    const RunRecord record = run_recording(recording, options, remembered, progress);
    const RunSummary summary = summarize(recording, options, record);
    out.frames = summary.frames;
    out.duration_s = summary.duration_s;
    out.nis_per_dof = summary.nis_per_dof;
    out.health = summary.health;
    if (done) {
      done(record, summary);
    }
    out.mistakes = calibration_mistakes(assumed, seen);
  } catch (const std::exception& error) {
    // A gross mistake may leave nothing to navigate with: then it is the answer.
    out.mistakes = calibration_mistakes(assumed, seen);
    if (out.mistakes.empty()) {
      throw;
    }
    out.failure = error.what();
  }
  if (out.health) {
    out.depths = depth_effects(assumed.theta, out.health->since_change);
  }
  if (out.mistakes.empty()) {
    out.cam1_offset = cam1_time_offset(assumed, seen);
    out.camera_offset = camera_time_offset(assumed, seen, recording.imu);
  }
  return out;
}

}  // namespace limber::app
