// SPDX-License-Identifier: MIT
#include "limber/run/run_recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <utility>

#include "limber/core/angle.hpp"
#include "limber/core/divergence_error.hpp"
#include "limber/core/median.hpp"
#include "limber/core/time.hpp"
#include "limber/datasets/interpolate.hpp"
#include "limber/navigate/navigator.hpp"
#include "limber/run/input_summary.hpp"
#include "limber/run/trajectory_row.hpp"
#include "limber/run/trusted_axes.hpp"
#include "remarks.hpp"
#include "shared_starts.hpp"
#include "start_from_sensors.hpp"
#include "start_from_truth.hpp"

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

constexpr double kLargestPosition = 1e9;  // [m]
constexpr double kKeptSeconds = 30.0;     // of RunRecord::last_frames

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

TrajectoryRow row_of(const Navigator& navigator) {
  const Estimate& estimate = navigator.estimate();
  constexpr Eigen::Index kPose = StateLayout::kPoseSize;
  const PredictedState body = navigator.predict(estimate.nav().t_ns);
  const Eigen::Index rest = body.body_covariance.rows() - kPose;
  return trajectory_row(body.nav, estimate.layout().motion,
                        body.body_covariance.topLeftCorner<kPose, kPose>(),
                        body.body_covariance.bottomRightCorner(rest, rest));
}

void keep_calibration(const Navigator& navigator, RunRecord& record) {
  const CalibrationEstimate estimate = navigator.calibration_estimate();
  if (estimate.parameters.any()) {
    record.calibration.push_back({navigator.estimate().nav().t_ns, estimate});
  }
}

bool is_sane(const TrajectoryRow& row) {
  return row.T_world_body.p.norm() < kLargestPosition && row.T_world_body.R.allFinite() &&
         row.v_world_body->allFinite() && row.covariance->allFinite();
}

/// Of the frames that the filter saw.
std::optional<ImuNoiseFactors> usual_imu_noise(const RunRecord& record) {
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
    record.imu_noise = usual_imu_noise(record);
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

[[noreturn]] void fail_diverged(Method method, std::size_t frame, std::int64_t t_ns, const std::string& what,
                                const std::vector<std::string>& remarks) {
  std::string message =
      fmt::format("{} diverged at frame {}, {} ns: {}", to_string(method), frame, t_ns, what);
  for (const std::string& remark : remarks) {
    message += "; " + remark;
  }
  throw DivergenceError(message);
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

/// The window's states, as far as they are known.
void write_states(const std::vector<SmoothedState>& states, RunRecord& record) {
  for (std::size_t k = 0; k < states.size(); ++k) {
    const SmoothedState& state = states[k];
    record.trajectory[k] =
        trajectory_row(state.nav, record.motion, state.pose_covariance, state.motion_covariance);
  }
}

/// Who looks at every frame gets those of the start as they stay: what tells of them is read before.
std::vector<SmoothedState> smoothed_ahead(const FrameSource& source, std::size_t next, std::size_t count,
                                          SensorWindow& window, WindowSmoother& smoother) {
  for (std::size_t n = next; n < count && window.smoothing && !window.smoothing->complete(); ++n) {
    window.ahead.push_back(read_frame(source, n));
    smoother.add(window.ahead.back().frame);
  }
  return smoother.states();
}

/// Writes the window's frames into the record; says how long it took and what was not known by then.
void keep_window(const SensorWindow& window, Navigator& navigator, RunRecord& record) {
  if (window.frames.empty()) {
    return;
  }
  record.frames_of_start = window.frames.size();
  const CalibrationEstimate calibration = navigator.calibration_estimate();
  record.trajectory.resize(window.frames.size());
  write_states(window.result.trajectory, record);
  for (std::size_t k = 0; k < window.frames.size(); ++k) {
    record.frames.push_back(window.frames[k]);
    if (window.result.solved && window.frames[k].observed > 0) {
      record.frames.back().status = UpdateStatus::kUpdated;
      record.frames.back().used = window.frames[k].observed;
    }
    record.frame_ms.push_back(window.frame_ms[k]);
    record.source_ms.push_back(window.source_ms[k]);
    if (calibration.parameters.any()) {
      record.calibration.push_back({window.frames[k].t_ns, calibration});
    }
  }
  const auto known = show_start(window.result, navigator);
  for (std::size_t k = 0; k < known.size(); ++k) {
    record.frames[record.frames.size() - known.size() + k].calibration = known[k];
  }
  const StartReport& report = window.report;
  if (!window.result.solved) {
    record.notes.push_back(
        fmt::format("no start was found in the first {:.2g} s, of which no pose is known: {}",
                    report.waited_s, report.missing));
    return;
  }
  record.notes.push_back(fmt::format(
      "{}{:.2g} s, which are smoothed: tilt known to {:.2g} deg, {}{}",
      report.status == StartStatus::kWaiting ? "nothing but a start, all " : "started from the first ",
      report.waited_s, report.tilt_sigma * kToDegrees,
      report.scale_sigma < 1.0 ? fmt::format("scale to {:.2g} %", 100.0 * report.scale_sigma)
                               : "scale not at all",
      report.missing.empty() ? "" : "; not known: " + report.missing));
  if (const auto& clock = window.result.clock_step) {
    record.notes.push_back(fmt::format(
        "the IMU's clock stepped between {:.3f} s and {:.3f} s: its samples since then were taken {:.4f} s "
        "{} than they are stamped, and are used so",
        1e-9 * static_cast<double>(clock->after_ns), 1e-9 * static_cast<double>(clock->before_ns),
        1e-9 * static_cast<double>(std::abs(clock->offset_ns)), clock->offset_ns > 0 ? "earlier" : "later"));
  }
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
  const bool asks_for_scale =
      options.watch && motion == MotionModel::kImu && trusts_length(options, motion, setup.calibration.theta);
  RunRecord record;
  const FrameSource frames = [&](std::size_t n) {
    StereoFrame frame = cleaner.clean(source(n));
    if (asks_for_scale) {
      keep(frame, record.last_frames);
    }
    return frame;
  };
  const std::size_t first = first_frame(recording, options, motion);
  const bool from_truth = options.start == StartMode::kGroundTruth;
  SensorWindow window;
  if (from_truth) {
    record.start = detail::start_from_truth(recording, options, setup, frame_time(recording, first));
  } else {
    window = sensor_window(recording, setup, frames, first, callbacks, shared);
    record.start = window.result.initial;
    record.sensor_start = window.report;
    record.clock_step_of_start = window.result.clock_step;
    record.stopped = window.stopped;
  }
  if (record.stopped && window.frames.empty()) return record;
  Navigator navigator(setup.navigator, setup.calibration, record.start);
  record.notes = setup.notes;
  record.theta_assumed = setup.calibration.theta;
  record.motion = motion;
  record.frames_of_recording = frame_count(recording);
  record.recording_partial = recording.partial;
  const auto remarks = detail::remarks_on_input(recording, record.motion, setup.navigator.gravity);
  append(record.notes, remarks);
  if (first > 0) {
    record.notes.push_back(fmt::format("{} frames skipped: before the first input{}", first,
                                       from_truth ? " or ground truth" : ""));
  }
  keep_window(window, navigator, record);
  WindowSmoother smoother(window.smoothing.get(), options.method, record.frames_of_start, options.threads);
  if (callbacks.observe) {
    write_states(
        smoothed_ahead(frames, first + record.frames.size(), frame_count(recording), window, smoother),
        record);
  }
  const auto done = [&](std::size_t row, const StereoFrame* frame) {
    if (callbacks.observe) {
      callbacks.observe({record.trajectory[row], record.frames[row], frame ? &navigator : nullptr, frame,
                         frame ? record.frame_ms.back() : 0.0});
    }
    if (callbacks.progress) {
      callbacks.progress(first + row + 1);
    }
  };
  for (std::size_t row = 0; row < record.frames.size(); ++row) {
    done(row, nullptr);
  }
  detail::PointCount points = window.points;
  InputFeed feed(recording, record.clock_step_of_start);
  for (std::size_t n = first + record.frames.size(); n < frame_count(recording); ++n) {
    if (record.stopped || (callbacks.stop && callbacks.stop())) {
      record.stopped = true;
      break;
    }
    const ReadFrame read = window.ahead.empty() ? read_frame(frames, n) : std::move(window.ahead.front());
    const StereoFrame& frame = read.frame;
    if (!window.ahead.empty()) {
      window.ahead.pop_front();
    }
    const auto begin_filter = Clock::now();
    record.source_ms.push_back(read.ms);
    points.add(frame);
    feed.feed(navigator, motion, frame.t_ns + navigator.clock_offset_ns());
    if (options.method == Method::kOracle) {
      navigator.show_true_rig(true_rig_at(recording.truth.rig, frame.t_ns));
    }
    try {
      record.frames.push_back(navigator.process(frame));
    } catch (const DivergenceError& error) {
      fail_diverged(options.method, n, frame.t_ns, error.what(), remarks);
    } catch (const std::exception& error) {
      if (!is_sane(row_of(navigator))) {  // whatever trips over such numbers is their fault
        fail_diverged(options.method, n, frame.t_ns, error.what(), remarks);
      }
      throw;
    }
    record.trajectory.push_back(row_of(navigator));
    keep_calibration(navigator, record);
    record.frame_ms.push_back(milliseconds(begin_filter, Clock::now()));
    if (!is_sane(record.trajectory.back()) || (record.frames.back().reset && options.stop_when_lost)) {
      fail_diverged(options.method, n, frame.t_ns,
                    fmt::format("the state is not finite, or further than {:g} m away", kLargestPosition),
                    remarks);
    }
    if (n + 1 == frame_count(recording)) {  // nothing comes any more that the rest of the work could wait for
      record.frames.back().calibration = navigator.calibration_report();
    }
    smoother.add(frame);
    done(record.frames.size() - 1, &frame);
  }
  write_states(smoother.states(), record);
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
         detail::remarks_on_measurements(record, options.method, setup.navigator.sigma_px, points));
  return record;
}

}  // namespace limber
