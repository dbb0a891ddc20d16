// SPDX-License-Identifier: MIT
#include "limber/run/run_recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <stdexcept>
#include <utility>

#include "limber/core/divergence_error.hpp"
#include "limber/datasets/interpolate.hpp"
#include "limber/navigate/navigator.hpp"
#include "limber/run/draw_initial_state.hpp"
#include "remarks.hpp"

namespace limber {
namespace {

using Clock = std::chrono::steady_clock;
using detail::covered_by_frames;
using detail::covered_seconds;
using detail::frame_time;

constexpr std::int64_t kWindowNs = 600'000'000;  // what an automatic start looks at
constexpr double kUnknownBiasGyro = 0.1;         // [rad/s], truth without biases
constexpr double kUnknownBiasAccel = 0.2;        // [m/s^2]
constexpr double kLargestPosition = 1e9;         // [m]
constexpr double kUnknownVelocity = 0.1;         // [m/s], truth without velocity: differences

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

template <typename Sample>
std::vector<Sample> between(const std::vector<Sample>& samples, std::int64_t begin_ns, std::int64_t end_ns) {
  std::vector<Sample> out;
  for (const Sample& sample : samples) {
    if (sample.t_ns >= begin_ns && sample.t_ns <= end_ns) {
      out.push_back(sample);
    }
  }
  return out;
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

/// Frames of the start window, kept so that the source is asked for each frame once and in order.
struct Lookahead {
  std::vector<StereoFrame> frames;
  std::vector<double> ms;
};

Lookahead look_ahead(const Recording& recording, const FrameSource& source, std::size_t first,
                     bool whole_window) {
  Lookahead out;
  const std::int64_t end = frame_time(recording, first) + (whole_window ? kWindowNs : 0);
  for (std::size_t n = first; n < frame_count(recording) && frame_time(recording, n) <= end; ++n) {
    const auto begin = Clock::now();
    out.frames.push_back(source(n));
    out.ms.push_back(milliseconds(begin, Clock::now()));
  }
  return out;
}

InitialState start_from_sensors(const Recording& recording, const RunSetup& setup, const Lookahead& ahead) {
  const std::int64_t begin = ahead.frames.front().t_ns;
  const std::int64_t end = ahead.frames.back().t_ns;
  const auto imu = between(recording.imu, begin - 20'000'000, end + 20'000'000);
  const auto odometry = between(recording.odometry, begin, end);
  return initialize({ahead.frames, imu, odometry}, setup.calibration, setup.navigator.motion,
                    setup.navigator.gravity);
}

/// Feeds inputs in time.
class InputFeed {
 public:
  explicit InputFeed(const Recording& recording) : recording_(recording) {}

  /// All samples up to the first one at or after t.
  void feed(Navigator& navigator, std::int64_t t_ns) {
    switch (navigator.options().motion) {
      case MotionModel::kImu:
        advance(recording_.imu, t_ns, [&](const ImuSample& s) { navigator.add_imu(s); });
        break;
      case MotionModel::kOdometry:
        advance(recording_.odometry, t_ns, [&](const OdometrySample& s) { navigator.add_odometry(s); });
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

TrajectoryRow row_of(const Navigator& navigator) {
  const Estimate& estimate = navigator.estimate();
  TrajectoryRow row;
  row.t_ns = estimate.nav.t_ns;
  row.T_world_body = estimate.nav.T_world_body;
  row.v_world_body = estimate.nav.v_world_body;
  if (estimate.layout().motion == MotionModel::kImu) {
    row.bias_gyro = estimate.nav.bias_gyro;
    row.bias_accel = estimate.nav.bias_accel;
  }
  row.covariance = estimate.P.diagonal_block<StateLayout::kPoseSize>(0);
  return row;
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
  FrameCleaner cleaner(setup.calibration, options.cleaning);
  const FrameSource frames = [&](std::size_t n) { return cleaner.clean(source(n)); };
  const std::size_t first = first_frame(recording, options, setup.navigator.motion);
  const bool from_truth = options.start == StartMode::kGroundTruth;
  Lookahead ahead = look_ahead(recording, frames, first, !from_truth);
  Navigator navigator(setup.navigator, setup.calibration,
                      from_truth ? start_from_truth(recording, options, setup, frame_time(recording, first))
                                 : start_from_sensors(recording, setup, ahead));
  RunRecord record;
  record.notes = setup.notes;
  record.motion = setup.navigator.motion;
  record.frames_of_recording = frame_count(recording);
  const auto remarks = detail::remarks_on_input(recording, record.motion, setup.navigator.gravity);
  append(record.notes, remarks);
  if (first > 0) {
    record.notes.push_back(fmt::format("{} frames skipped: before the first input{}", first,
                                       from_truth ? " or ground truth" : ""));
  }
  InputFeed feed(recording);
  detail::PointCount points;
  for (std::size_t n = first; n < frame_count(recording); ++n) {
    if (stop && stop()) {
      record.stopped = true;
      break;
    }
    const std::size_t k = n - first;
    const auto begin_source = Clock::now();
    const StereoFrame frame = k < ahead.frames.size() ? std::move(ahead.frames[k]) : frames(n);
    const auto begin_filter = Clock::now();
    record.source_ms.push_back(k < ahead.ms.size() ? ahead.ms[k] : milliseconds(begin_source, begin_filter));
    count(frame, points);
    feed.feed(navigator, frame.t_ns);
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
    if (!is_sane(record.trajectory.back())) {
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
