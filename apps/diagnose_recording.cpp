// SPDX-License-Identifier: MIT
#include "diagnose_recording.hpp"

#include <exception>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "first_frames.hpp"
#include "limber/core/divergence_error.hpp"
#include "limber/core/time.hpp"
#include "limber/diagnose/calibration_mistakes.hpp"
#include "limber/diagnose/imu_mistakes.hpp"
#include "limber/diagnose/judge_run.hpp"

namespace limber::app {

namespace {

/// The frames of a run, kept for all that looks at them once more.
class SeenFrames {
 public:
  /// @param source  must outlive this
  SeenFrames(const FrameSource& source, const StereoCalibration& assumed)
      : source_(source), readout_(assumed) {}

  const StereoFrame& take(std::size_t n) {
    first_ = frames_.empty() ? n : first_;
    frames_.push_back(source_(n));
    readout_.add(frames_.back());
    return frames_.back();
  }

  /// Mistakes are looked for in as many as a run looks at, also where it failed before.
  void take_as_many_as_a_run(std::size_t count, const std::function<bool()>& stop) {
    for (std::size_t n = first_ + frames_.size();
         n < count && frames_.size() < kLastLook && !(stop && stop()); ++n) {
      (void)take(n);
    }
  }

  const StereoFrame& again(std::size_t n) const { return frames_.at(n - first_); }
  std::optional<ReadoutTime> readout() const { return readout_.estimate(); }
  std::vector<StereoFrame> release() { return std::move(frames_); }

 private:
  const FrameSource& source_;
  ReadoutWatch readout_;
  std::vector<StereoFrame> frames_;
  std::size_t first_ = 0;
};

/// The same recording by a filter that trusts the calibration, which may lead it astray.
void compare_with_ekf(const Recording& recording, RunOptions options, const FrameSource& frames,
                      const RunRecord& record, Diagnosis& out) {
  options.method = Method::kEkf;
  options.watch = false;
  try {
    const RunRecord trusting = run_recording(recording, options, frames);
    out.pose = pose_loss(poses_of(trusting.trajectory), poses_of(record.trajectory));
  } catch (const DivergenceError& error) {
    out.ekf_failure = error.what();
  }
}

/// What a run says of the rig and of itself. @return its summary
RunSummary judge(const Recording& recording, const RunOptions& options, const StereoCalibration& assumed,
                 RunRecord& record, Diagnosis& out) {
  RunSummary summary = judge_run(recording, options, out.readout, record);
  if (summary.readout_contradicted) {
    out.readout_contradicted = in_words(*out.readout, assumed);
  }
  out.frames = summary.frames;
  out.frames_of_recording = record.frames_of_recording;
  out.stopped = record.stopped;
  out.duration_s = summary.duration_s;
  out.nis_per_dof = summary.nis_per_dof;
  if (const auto lost_ns = summary.inputs.lost_since_ns) {
    out.lost_since_s = seconds_between(record.frames.front().t_ns, *lost_ns);
    if (summary.health) {
      summary.health->verdict = verdict_by_lines(*summary.health);
    }
  }
  out.health = summary.health;
  out.metric = has_scale(record.motion);
  if (summary.health && !summary.readout_contradicted && !out.stopped && !out.lost_since_s) {
    out.state = HealthState{recording.name,
                            {camera_in_words(assumed.cam0), camera_in_words(assumed.cam1)},
                            rig_record(summary.health->present, assumed.theta, out.metric)};
  }
  return summary;
}

/// What is wrong with the calibration as it was given, else with clocks and mount beside the rig as it was
/// found.
void add_mistakes(const Recording& recording, const StereoCalibration& assumed,
                  const std::vector<StereoFrame>& seen, const RunOptions& options, const RunRecord* record,
                  Diagnosis& out) {
  out.mistakes = calibration_mistakes(assumed, seen);
  const std::vector<std::string> of_imu = imu_mistakes(assumed, seen, recording.imu, options.gravity);
  out.mistakes.insert(out.mistakes.end(), of_imu.begin(), of_imu.end());
  StereoCalibration found = assumed;
  if (out.health) {
    out.depths = depth_effects(assumed.theta, out.health->present.estimate, out.metric);
    found.theta += out.health->present.estimate.delta;
  }
  if (out.mistakes.empty() && out.readout_contradicted.empty()) {
    out.offsets = sensor_offsets(found, seen, recording.imu);
    out.offsets.corrected_cameras = record != nullptr ? corrected_clock(*record) : 0.0;
    if (record != nullptr && !out.lost_since_s) {
      out.offsets.inertial = check_inertial(recording, options, *record);
    }
  }
  if (out.health && verdict_beside(out.offsets, *out.health) != out.health->verdict) {
    out.state.reset();
  }
}

/// A gross mistake may leave nothing to navigate with: then it is the answer.
void explain(const std::exception_ptr& failure, Diagnosis& out) {
  try {
    std::rethrow_exception(failure);
  } catch (const std::exception& error) {
    if (out.mistakes.empty() && clock_mistakes(out.offsets).empty()) {
      throw;
    }
    out.failure = error.what();
  }
}

}  // namespace

Diagnosis diagnose_recording(const Recording& recording, const RunOptions& options, const ImageFrames& frames,
                             const std::function<void(std::size_t)>& progress,
                             const std::function<void(const RunRecord&, const RunSummary&)>& done,
                             const std::function<bool()>& stop) {
  Diagnosis out;
  out.dataset = recording.name;
  out.judged_by = watch_options(options);
  const StereoCalibration assumed = corrected(recording.calibration, options.assume_error);
  SeenFrames seen(frames.frames, assumed);
  std::exception_ptr failure;
  std::optional<std::pair<RunRecord, RunSummary>> ran;
  try {
    RunRecord record = run_recording(recording, options, [&](std::size_t n) { return seen.take(n); },
                                     {.progress = progress, .stop = stop});
    if (record.frames.empty()) {
      throw std::runtime_error("stopped before the first frame: nothing can be said");
    }
    add_damaged(frames, record);
    out.readout = seen.readout();
    RunSummary summary = judge(recording, options, assumed, record, out);
    if (!out.stopped && !out.lost_since_s) {
      compare_with_ekf(
          recording, options, [&](std::size_t n) { return seen.again(n); }, record, out);
    }
    ran.emplace(std::move(record), std::move(summary));
  } catch (const DivergenceError&) {
    failure = std::current_exception();
  } catch (const std::invalid_argument&) {  // no frame to start from
    failure = std::current_exception();
  }
  if (failure) {
    seen.take_as_many_as_a_run(frame_count(recording), stop);
  }
  add_mistakes(recording, assumed, at_stamps(seen.release(), assumed), options, ran ? &ran->first : nullptr,
               out);
  if (failure) {
    explain(failure, out);
  }
  if (ran && done) {
    auto& [record, summary] = *ran;
    summary.mistakes = out.mistakes;
    add_offsets(out.offsets, summary);
    done(record, summary);
  }
  return out;
}

}  // namespace limber::app
