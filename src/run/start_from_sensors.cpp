// SPDX-License-Identifier: MIT
#include "start_from_sensors.hpp"

#include <algorithm>
#include <utility>

namespace limber::detail {
namespace {

// The frames of the start get poses smoothed over that long [ns].
constexpr std::int64_t kSmoothedNs = 4'000'000'000;
// What a start may take of a short recording: of the rest alone health and NIS are known.
constexpr double kLongestShare = 0.5, kLongestMovingShare = 0.8;
constexpr double kLeastFiltered = 1.0;  // [s]

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

}  // namespace

SensorWindow start_from_sensors(const Recording& recording, const RunSetup& setup, const FrameSource& source,
                                std::size_t first, const RunCallbacks& callbacks) {
  const MotionModel motion = setup.navigator.motion;
  StartOptions options;
  const double duration_s = 1e-9 * static_cast<double>(frame_time(recording, frame_count(recording) - 1) -
                                                       frame_time(recording, first));
  options.longest_s = std::min(options.longest_s, kLongestShare * duration_s);
  options.longest_moving_s = std::min(
      options.longest_moving_s,
      std::max(options.longest_s, std::min(kLongestMovingShare * duration_s, duration_s - kLeastFiltered)));
  SensorStart start(setup.navigator, setup.calibration, options);
  InputFeed feed(recording);
  SensorWindow out;
  std::size_t n = first;
  while (n < frame_count(recording) && out.report.status == StartStatus::kWaiting) {
    if (callbacks.stop && callbacks.stop()) {
      out.stopped = true;
      break;
    }
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
    if (callbacks.wait && out.report.status == StartStatus::kWaiting)
      callbacks.wait({read.frame, out.report, out.frames.size()});
    if (motion == MotionModel::kOdometry) {
      out.ahead.push_back(std::move(read));
    } else {
      out.points.add(read.frame);
    }
  }
  if (out.frames.empty()) return out;  // stopped
  out.result = start.result();
  if (out.report.status == StartStatus::kWaiting) out.report = out.result.report;
  if (motion == MotionModel::kOdometry) {
    out.frames.clear();
  } else if (!out.stopped) {
    smooth(recording, source, n, motion, feed, start, out);
  }
  return out;
}

}  // namespace limber::detail
