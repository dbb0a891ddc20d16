// SPDX-License-Identifier: MIT
#include "limber/run/run_recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <optional>
#include <stdexcept>
#include <utility>

#include "limber/core/divergence_error.hpp"
#include "limber/datasets/interpolate.hpp"
#include "limber/initialize/sensor_start.hpp"
#include "limber/navigate/navigator.hpp"
#include "limber/run/draw_initial_state.hpp"
#include "limber/run/input_summary.hpp"
#include "remarks.hpp"

namespace limber {
namespace {

using Clock = std::chrono::steady_clock;
using detail::covered_by_frames;
using detail::covered_seconds;
using detail::frame_time;

// The frames of the start get poses smoothed over that long [ns].
constexpr std::int64_t kSmoothedNs = 4'000'000'000;
constexpr double kLongestShare = 0.5;  // of a short recording, that a start may take
constexpr double kDegreesPerRadian = 180.0 / M_PI;
constexpr double kUnknownBiasGyro = 0.1;   // [rad/s], truth without biases
constexpr double kUnknownBiasAccel = 0.2;  // [m/s^2]
constexpr double kLargestPosition = 1e9;   // [m]
constexpr double kUnknownVelocity = 0.1;   // [m/s], truth without velocity: differences

double milliseconds(Clock::time_point begin, Clock::time_point end) {
  return std::chrono::duration<double, std::milli>(end - begin).count();
}

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
    if (driven && (!from_truth || groundtruth_at(recording.groundtruth, t))) {
      return n;
    }
  }
  std::string covered = "the frames cover " + covered_by_frames(recording);
  if (inputs) {
    covered += fmt::format(", the {} {}", motion == MotionModel::kImu ? "IMU" : "odometry",
                           covered_seconds(inputs->first, inputs->second));
  }
  if (from_truth) {
    covered += ", ground truth " +
               covered_seconds(recording.groundtruth.front().t_ns, recording.groundtruth.back().t_ns);
  }
  throw std::invalid_argument(recording.name + ": no frame to start from: " + covered +
                              "; do they have the same clock?");
}

/// Velocity of a truth that does not give it.
Eigen::Vector3d differenced_velocity(const Recording& recording, std::int64_t t_ns) {
  const auto& truth = recording.groundtruth;
  const auto it = std::lower_bound(truth.begin(), truth.end(), t_ns,
                                   [](const GroundTruthState& s, std::int64_t t) { return s.t_ns < t; });
  const std::size_t k = std::min<std::size_t>(static_cast<std::size_t>(it - truth.begin()), truth.size() - 1);
  const GroundTruthState& a = truth[k > 0 ? k - 1 : 0];
  const GroundTruthState& b = truth[std::min(k + 1, truth.size() - 1)];
  return a.t_ns == b.t_ns ? Eigen::Vector3d::Zero()
                          : Eigen::Vector3d((b.p_world_body - a.p_world_body) /
                                            (1e-9 * static_cast<double>(b.t_ns - a.t_ns)));
}

InitialState start_from_truth(const Recording& recording, const RunOptions& options, const RunSetup& setup,
                              std::int64_t t_ns) {
  GroundTruthState truth = *groundtruth_at(recording.groundtruth, t_ns);
  InitialSigma sigma = options.initial;
  InitialSigma error = options.initial_error.value_or(options.initial);
  if (!recording.groundtruth_has_velocity) {
    truth.v_world_body = differenced_velocity(recording, t_ns);
    sigma.velocity = std::max(sigma.velocity, kUnknownVelocity);
    error.velocity = std::max(error.velocity, kUnknownVelocity);
  }
  InitialSigma drawn = error;
  if (!recording.groundtruth_has_biases) {
    drawn.bias_accel = drawn.bias_gyro = 0.0;
    sigma.bias_accel = std::max(sigma.bias_accel, kUnknownBiasAccel);
    sigma.bias_gyro = std::max(sigma.bias_gyro, kUnknownBiasGyro);
  }
  const GroundTruthState start = draw_initial_state(truth, drawn, options.seed, options.run);
  NavigationState nav;
  nav.t_ns = t_ns;
  nav.T_world_body = {start.R_world_body, start.p_world_body};
  nav.v_world_body = start.v_world_body;
  nav.bias_gyro = start.bias_gyro;
  nav.bias_accel = start.bias_accel;
  sigma.rate = 0.5;  // the truth gives no rate
  return make_initial_state(nav, setup.navigator.motion, sigma);
}

/// Feeds inputs in time.
class InputFeed {
 public:
  explicit InputFeed(const Recording& recording) : recording_(recording) {}

  /// All samples up to the first one at or after t, to a navigator or a start.
  template <typename Receiver>
  void feed(Receiver& receiver, MotionModel motion, std::int64_t t_ns) {
    switch (motion) {
      case MotionModel::kImu:
        advance(recording_.imu, t_ns, [&](const ImuSample& s) { receiver.add_imu(s); });
        break;
      case MotionModel::kOdometry:
        advance(recording_.odometry, t_ns, [&](const OdometrySample& s) { receiver.add_odometry(s); });
        break;
      case MotionModel::kConstantVelocity:
        break;
    }
  }

 private:
  template <typename Sample, typename Add>
  void advance(const std::vector<Sample>& samples, std::int64_t t_ns, Add add) {
    while (next_ < samples.size() && (next_ == 0 || samples[next_ - 1].t_ns < t_ns)) {
      add(samples[next_++]);
    }
  }

  const Recording& recording_;
  std::size_t next_ = 0;
};

TrajectoryRow row_of(const NavigationState& nav, MotionModel motion,
                     const Eigen::Matrix<double, 6, 6>& pose_covariance) {
  TrajectoryRow row;
  row.t_ns = nav.t_ns;
  row.T_world_body = nav.T_world_body;
  row.v_world_body = nav.v_world_body;
  if (motion == MotionModel::kImu) {
    row.bias_gyro = nav.bias_gyro;
    row.bias_accel = nav.bias_accel;
  }
  row.covariance = pose_covariance;
  return row;
}

TrajectoryRow row_of(const Navigator& navigator) {
  const Estimate& estimate = navigator.estimate();
  return row_of(estimate.nav, estimate.layout().motion, estimate.P.diagonal_block<StateLayout::kPoseSize>(0));
}

void keep_calibration(const Navigator& navigator, RunRecord& record) {
  const CalibrationEstimate estimate = navigator.calibration_estimate();
  if (estimate.parameters.any()) {
    record.calibration.push_back({navigator.estimate().nav.t_ns, estimate});
  }
}

bool is_sane(const TrajectoryRow& row) {
  return row.T_world_body.p.norm() < kLargestPosition && row.T_world_body.R.allFinite() &&
         row.v_world_body->allFinite() && row.covariance->allFinite();
}

void take_map(const Navigator& navigator, RunRecord& record) {
  const Estimate& estimate = navigator.estimate();
  const std::vector<Eigen::Vector3d> positions = estimate.landmark_positions();
  for (std::size_t k = 0; k < positions.size(); ++k) {
    record.landmarks[estimate.landmarks()[k].track_id] = positions[k];
  }
  record.theta = navigator.estimate().theta;
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

void count(const StereoFrame& frame, detail::PointCount& points) {
  for (const StereoObservation& point : frame.observations) {
    points.left += point.in_cam0 ? 1 : 0;
    points.right += point.in_cam1 ? 1 : 0;
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

/// A frame that was read, and how long that took.
struct ReadFrame {
  StereoFrame frame;
  double ms = 0.0;
};

ReadFrame read_frame(const FrameSource& source, std::size_t n) {
  const auto begin = Clock::now();
  StereoFrame frame = source(n);
  return {std::move(frame), milliseconds(begin, Clock::now())};
}

/// The frames that a start from the sensors has used up, and what it made of them.
struct SensorWindow {
  SensorStartResult result;  // its trajectory is that of `frames`
  StartReport report;
  std::vector<FrameReport> frames;
  std::vector<double> source_ms, frame_ms;
  detail::PointCount points;
  std::deque<ReadFrame> ahead;  // read, and still to be processed
};

/// Reads a little further and lets the window's frames have what those behind it say of them.
void smooth(const Recording& recording, const FrameSource& source, std::size_t next, MotionModel motion,
            InputFeed& feed, SensorStart& start, SensorWindow& window) {
  const std::int64_t begin_ns = window.frames.front().t_ns;
  for (std::size_t n = next; n < frame_count(recording) && frame_time(recording, n) - begin_ns <= kSmoothedNs;
       ++n) {
    window.ahead.push_back(read_frame(source, n));
    feed.feed(start, motion, window.ahead.back().frame.t_ns);
    (void)start.add_frame(window.ahead.back().frame);
  }
  const std::size_t frames = window.result.trajectory.size();
  window.result.trajectory = start.result().trajectory;
  window.result.trajectory.resize(frames);
}

SensorWindow start_from_sensors(const Recording& recording, const RunSetup& setup, const FrameSource& source,
                                std::size_t first) {
  const MotionModel motion = setup.navigator.motion;
  StartOptions options;
  const std::int64_t duration_ns =
      frame_time(recording, frame_count(recording) - 1) - frame_time(recording, first);
  options.longest_s = std::min(options.longest_s, kLongestShare * 1e-9 * static_cast<double>(duration_ns));
  SensorStart start(setup.navigator, setup.calibration, options);
  InputFeed feed(recording);
  SensorWindow out;
  std::size_t n = first;
  while (n < frame_count(recording) && out.report.status == StartStatus::kWaiting) {
    ReadFrame read = read_frame(source, n++);
    const auto begin = Clock::now();
    feed.feed(start, motion, read.frame.t_ns);
    out.report = start.add_frame(read.frame);
    FrameReport report;
    report.t_ns = read.frame.t_ns;
    report.observed = read.frame.observations.size();
    out.frames.push_back(report);
    out.frame_ms.push_back(milliseconds(begin, Clock::now()));
    out.source_ms.push_back(read.ms);
    if (motion == MotionModel::kOdometry) {
      out.ahead.push_back(std::move(read));
    } else {
      count(read.frame, out.points);
    }
  }
  out.result = start.result();
  if (motion == MotionModel::kOdometry) {
    out.frames.clear();
  } else {
    smooth(recording, source, n, motion, feed, start, out);
  }
  return out;
}

/// Writes the window's frames into the record; says how long it took and what was not known by then.
void keep_window(const SensorWindow& window, const Navigator& navigator, RunRecord& record) {
  if (window.frames.empty()) {
    return;
  }
  const CalibrationEstimate calibration = navigator.calibration_estimate();
  for (std::size_t k = 0; k < window.frames.size(); ++k) {
    const SmoothedState& state = window.result.trajectory[k];
    record.trajectory.push_back(row_of(state.nav, record.motion, state.pose_covariance));
    record.frames.push_back(window.frames[k]);
    if (window.result.solved && window.frames[k].observed > 0) {
      record.frames.back().status = UpdateStatus::kUpdated;
      record.frames.back().used = window.frames[k].observed;
    }
    record.frame_ms.push_back(window.frame_ms[k]);
    record.source_ms.push_back(window.source_ms[k]);
    if (calibration.parameters.any()) {
      record.calibration.push_back({state.nav.t_ns, calibration});
    }
  }
  const StartReport& report = window.report;
  record.notes.push_back(
      fmt::format("started from the first {:.2g} s, which are smoothed: tilt known to {:.2g} deg, scale "
                  "to {:.2g} %{}",
                  report.waited_s, report.tilt_sigma * kDegreesPerRadian, 100.0 * report.scale_sigma,
                  report.missing.empty() ? "" : "; not known: " + report.missing));
}

}  // namespace

std::size_t frame_count(const Recording& recording) {
  return recording.images.empty() ? recording.frames.size() : recording.images.size();
}

FrameSource matched_frames(const Recording& recording) {
  return [&recording](std::size_t n) { return recording.frames[n]; };
}

RunRecord run_recording(const Recording& recording, const RunOptions& options, const FrameSource& source,
                        const std::function<void(std::size_t)>& progress, const FrameObserver& observe,
                        const std::function<bool()>& stop) {
  const RunSetup setup = set_up_run(recording, options);
  const MotionModel motion = setup.navigator.motion;
  FrameCleaner cleaner(setup.calibration, options.cleaning);
  const FrameSource frames = [&](std::size_t n) { return cleaner.clean(source(n)); };
  const std::size_t first = first_frame(recording, options, motion);
  const bool from_truth = options.start == StartMode::kGroundTruth;
  SensorWindow window;
  if (!from_truth) {
    window = start_from_sensors(recording, setup, frames, first);
  }
  RunRecord record;
  record.start = from_truth ? start_from_truth(recording, options, setup, frame_time(recording, first))
                            : window.result.initial;
  Navigator navigator(setup.navigator, setup.calibration, record.start);
  record.notes = setup.notes;
  record.motion = motion;
  record.frames_of_recording = frame_count(recording);
  const auto remarks = detail::remarks_on_input(recording, record.motion, setup.navigator.gravity);
  append(record.notes, remarks);
  if (first > 0) {
    record.notes.push_back(fmt::format("{} frames skipped: before the first input{}", first,
                                       from_truth ? " or ground truth" : ""));
  }
  keep_window(window, navigator, record);
  for (std::size_t k = 1; progress && k <= window.frames.size(); ++k) {
    progress(first + k);
  }
  detail::PointCount points = window.points;
  InputFeed feed(recording);
  for (std::size_t n = first + record.frames.size(); n < frame_count(recording); ++n) {
    if (stop && stop()) {
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
    count(frame, points);
    feed.feed(navigator, motion, frame.t_ns);
    if (options.method == Method::kOracle) {
      navigator.assume_theta(calibration_at(recording.calibration_true, frame.t_ns));
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
    if (observe) {
      observe(navigator, record.frames.back());
    }
    if (progress) {
      progress(n + 1);
    }
  }
  take_map(navigator, record);
  append(record.notes, remarks_on_inputs(summarize_inputs(record.frames)));
  record.cleaning = cleaner.report();
  append(record.notes, in_words(record.cleaning));
  if (record.stopped) {
    record.notes.push_back(fmt::format("stopped after {} of {} frames: these are partial results",
                                       record.frames.size(), record.frames_of_recording - first));
  }
  append(record.notes, detail::remarks_on_measurements(record, options.method, points));
  return record;
}

}  // namespace limber
