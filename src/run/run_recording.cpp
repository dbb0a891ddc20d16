// SPDX-License-Identifier: MIT
#include "limber/run/run_recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <utility>

#include "frame_by_frame.hpp"
#include "limber/core/median.hpp"
#include "limber/core/time.hpp"
#include "limber/datasets/interpolate.hpp"
#include "limber/navigate/navigator.hpp"
#include "limber/run/input_summary.hpp"
#include "remarks.hpp"
#include "shared_starts.hpp"
#include "start_from_sensors.hpp"
#include "start_from_truth.hpp"
#include "window_record.hpp"

namespace limber {
namespace {

using detail::Clock;
using detail::covered_by_frames;
using detail::covered_seconds;
using detail::frame_time;
using detail::InputFeed;
using detail::milliseconds;
using detail::read_frame;
using detail::ReadFrame;
using detail::SensorWindow;
using detail::WindowSmoother;

constexpr double kKeptSeconds = 30.0;  // of RunRecord::last_frames

/// The first and the last time of the inputs that drive the prediction; nothing if it needs none.
std::optional<std::pair<std::int64_t, std::int64_t>> input_times(const Recording& recording,
                                                                 MotionModel motion) {
  switch (motion) {
    case MotionModel::kImu:
      return std::pair(recording.imu.front().t_ns, recording.imu.back().t_ns);
    case MotionModel::kOdometry:
      return std::pair(recording.odometry.front().t_ns, recording.odometry.back().t_ns);
    case MotionModel::kConstantVelocity:
      break;
  }
  return std::nullopt;
}

/// The first frame that the prediction's inputs reach, and for a ground truth start the truth.
std::size_t first_frame(const Recording& recording, const RunOptions& options, MotionModel motion) {
  const auto inputs = input_times(recording, motion);
  const bool from_truth = options.start == StartMode::kGroundTruth;
  for (std::size_t n = 0; n < frame_count(recording); ++n) {
    const std::int64_t t = frame_time(recording, n);
    const bool driven = !inputs || (inputs->first <= t && t <= inputs->second);
    if (driven && (!from_truth || groundtruth_at(recording.truth.motion.states, t))) {
      return n;
    }
  }
  std::string covered = "the frames cover " + covered_by_frames(recording);
  if (inputs) {
    covered += fmt::format(", the {} {}", motion == MotionModel::kImu ? "IMU" : "odometry",
                           covered_seconds(inputs->first, inputs->second));
  }
  if (from_truth) {
    covered += ", ground truth " + covered_seconds(recording.truth.motion.states.front().t_ns,
                                                   recording.truth.motion.states.back().t_ns);
  }
  throw std::invalid_argument(recording.name + ": no frame to start from: " + covered +
                              "; do they have the same clock?");
}

/// Of the frames that the filter saw.
std::optional<ImuNoiseFactors> usual_noise(const RunRecord& record) {
  std::vector<double> gyro, accel;
  for (std::size_t k = record.frames_of_start; k < record.frames.size(); ++k) {
    gyro.push_back(record.frames[k].imu_noise.gyro);
    accel.push_back(record.frames[k].imu_noise.accel);
  }
  return gyro.empty() ? std::nullopt
                      : std::optional<ImuNoiseFactors>({upper_median(gyro), upper_median(accel)});
}

void take_end(const Navigator& navigator, RunRecord& record) {
  const bool is_start_alone = record.frames.size() == record.frames_of_start;
  if ((record.stopped || is_start_alone) && !record.frames.empty()) {
    record.frames.back().calibration = navigator.calibration_report();
  }
  const Estimate& estimate = navigator.estimate();
  const std::vector<Eigen::Vector3d> positions = estimate.landmark_positions();
  for (std::size_t k = 0; k < positions.size(); ++k) {
    record.landmarks[estimate.landmarks()[k].track_id] = positions[k];
  }
  record.theta = navigator.estimate().theta();
  if (const LearnedPixelNoise* learned = navigator.pixel_noise()) {
    record.pixel_noise = learned->report();
  }
  if (navigator.imu_noise()) {
    record.imu_noise = usual_noise(record);
  } else if (navigator.learned_motion_noise()) {
    record.motion_noise = usual_noise(record);
  }
  if (const LearnedOdometryNoise* learned = navigator.odometry_noise(); learned && learned->knows()) {
    record.odometry_noise = learned->white();
  }
}

void keep(const StereoFrame& frame, std::deque<StereoFrame>& last) {
  last.push_back(frame);
  while (seconds_between(last.front().t_ns, frame.t_ns) > kKeptSeconds) {
    last.pop_front();
  }
}

/// Each note once.
void append(std::vector<std::string>& notes, const std::vector<std::string>& more) {
  for (const std::string& note : more) {
    if (std::find(notes.begin(), notes.end(), note) == notes.end()) {
      notes.push_back(note);
    }
  }
}

/// A start of its own, or one that a run before has solved. The frames of that go through the cleaning, which
/// remembers what it has seen.
SensorWindow sensor_window(const Recording& recording, const RunSetup& setup, const FrameSource& frames,
                           std::size_t first, const RunCallbacks& callbacks, SharedStarts* shared) {
  if (std::optional<SensorWindow> known = shared ? shared->kept().find(setup) : std::nullopt) {
    for (std::size_t n = first; n < first + known->frames.size() + known->ahead.size(); ++n) {
      (void)frames(n);
    }
    known->elsewhere_s = 1e-3 * std::accumulate(known->frame_ms.begin(), known->frame_ms.end(), 0.0);
    return *std::move(known);
  }
  SensorWindow out =
      detail::start_from_sensors(recording, setup, frames, first, callbacks, shared != nullptr);
  if (shared && !out.stopped) {
    shared->kept().keep(setup, out);
  }
  return out;
}

/// From the truth, or from the sensors: then with the frames that this has used up.
SensorWindow begin(const Recording& recording, const RunOptions& options, const RunSetup& setup,
                   const FrameSource& frames, std::size_t first, const RunCallbacks& callbacks,
                   SharedStarts* shared, RunRecord& record) {
  if (options.start == StartMode::kGroundTruth) {
    record.start = detail::start_from_truth(recording, options, setup, frame_time(recording, first));
    return {};
  }
  SensorWindow window = sensor_window(recording, setup, frames, first, callbacks, shared);
  record.start = window.result.initial;
  record.sensor_start = window.report;
  record.clock_step_of_start = window.result.clock_step;
  record.stopped = window.stopped;
  return window;
}

/// What the run is of, and what is remarkable before its first frame.
void describe(const Recording& recording, const RunOptions& options, const RunSetup& setup, std::size_t first,
              RunRecord& record) {
  record.notes = setup.notes;
  record.theta_assumed = setup.calibration.theta;
  record.motion = setup.navigator.motion;
  record.frames_of_recording = frame_count(recording);
  record.recording_partial = recording.partial;
  append(record.notes, detail::remarks_on_input(recording, record.motion, setup.navigator.gravity));
  if (first > 0) {
    record.notes.push_back(fmt::format("{} frames skipped: before the first input{}", first,
                                       options.start == StartMode::kGroundTruth ? " or ground truth" : ""));
  }
}

/// One that was read ahead, or the recording's.
ReadFrame next_frame(const FrameSource& frames, std::size_t n, SensorWindow& window) {
  if (window.ahead.empty()) {
    return read_frame(frames, n);
  }
  ReadFrame out = std::move(window.ahead.front());
  window.ahead.pop_front();
  return out;
}

}  // namespace

std::size_t frame_count(const SensorData& sensors) {
  return sensors.images.empty() ? sensors.frames.size() : sensors.images.size();
}

void FrontendRecord::add(const StereoFrame& frame, double decoding_ms, double tracking_ms) {
  t_ns.push_back(frame.t_ns);
  decode_ms.push_back(decoding_ms);
  track_ms.push_back(tracking_ms);
  for (const StereoObservation& point : frame.observations) {
    left_points += point.in_cam0;
    right_points += point.in_cam1;
    tracks.insert(point.track_id);
  }
}

void add_frontend(const FrontendRecord& frontend, RunRecord& record) {
  std::map<std::int64_t, double> spent_ms;
  for (std::size_t k = 0; k < frontend.t_ns.size(); ++k) {
    spent_ms[frontend.t_ns[k]] = frontend.decode_ms[k] + frontend.track_ms[k];
  }
  for (std::size_t k = 0; k < record.trajectory.size(); ++k) {
    record.source_ms[k] = spent_ms[record.trajectory[k].t_ns];
  }
  record.frontend = frontend;
  record.elapsed_s += 1e-3 * frontend.earlier_ms;
}

FrameSource matched_frames(const SensorData& sensors) {
  return [&sensors](std::size_t n) { return sensors.frames[n]; };
}

RunRecord run_recording(const Recording& recording, const RunOptions& options, const FrameSource& source,
                        const RunCallbacks& callbacks, SharedStarts* shared) {
  const auto begin_run = Clock::now();
  const RunSetup setup = set_up_run(recording, options);
  const MotionModel motion = setup.navigator.motion;
  FrameCleaner cleaner(setup.calibration, options.cleaning);
  const bool asks_once_more = options.watch && motion == MotionModel::kImu;
  RunRecord record;
  const FrameSource frames = [&](std::size_t n) {
    StereoFrame frame = cleaner.clean(source(n));
    if (asks_once_more) {
      keep(frame, record.last_frames);
    }
    return frame;
  };
  const std::size_t first = first_frame(recording, options, motion);
  SensorWindow window = begin(recording, options, setup, frames, first, callbacks, shared, record);
  if (record.stopped && window.frames.empty()) return record;
  Navigator navigator(setup.navigator, setup.calibration, record.start);
  describe(recording, options, setup, first, record);
  detail::keep_window(window, navigator, record);
  WindowSmoother smoother(window.smoothing.get(), options.method, record.frames_of_start, options.threads);
  if (callbacks.observe) {
    detail::write_states(detail::smoothed_ahead(frames, first + record.frames.size(), frame_count(recording),
                                                window, smoother),
                         record);
  }
  detail::FrameByFrame run(recording, options, setup, callbacks, first, window.points, navigator, record);
  while (run.next() < frame_count(recording) && !run.is_stopped()) {
    run.take(next_frame(frames, run.next(), window), smoother);
  }
  detail::write_states(smoother.states(), record);
  record.elapsed_s = window.elsewhere_s + 1e-3 * milliseconds(begin_run, Clock::now());
  take_end(navigator, record);
  append(record.notes, remarks_on_inputs(summarize_inputs(record.frames)));
  record.cleaning = cleaner.report();
  append(record.notes, in_words(record.cleaning));
  if (record.stopped) {
    record.notes.push_back(fmt::format("stopped after {} of {} frames: these are partial results",
                                       record.frames.size(), record.frames_of_recording - first));
  }
  append(record.notes,
         detail::remarks_on_measurements(record, options.method, setup.navigator.sigma_px, run.points()));
  return record;
}

}  // namespace limber
