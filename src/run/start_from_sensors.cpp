// SPDX-License-Identifier: MIT
#include "start_from_sensors.hpp"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "limber/core/time.hpp"

namespace limber::detail {
namespace {

// What a start may take of a short recording: of the rest alone health and NIS are known.
constexpr double kLongestShare = 0.5, kLongestMovingShare = 0.8;
constexpr double kLeastFiltered = 1.0;  // [s]

/// The method of this start that may begin otherwise.
std::optional<Method> counterpart(const RunSetup& setup) {
  NavigatorOptions other = setup.navigator;
  other.method = may_trust_rig(other) ? Method::kEkfFull : Method::kAdaptive;
  return same_start(setup.navigator, setup.calibration, other, setup.calibration)
             ? std::optional(other.method)
             : std::nullopt;
}

/// The first frames are the window's; the others are the filter's first.
void keep_used(std::size_t used, std::vector<ReadFrame> seen, SensorWindow& window) {
  window.frames.resize(used);
  window.frame_ms.resize(used);
  for (std::size_t k = 0; k < seen.size(); ++k) {
    if (k < used) {
      window.source_ms.push_back(seen[k].ms);
      window.points.add(seen[k].frame);
    } else {
      window.ahead.push_back(std::move(seen[k]));
    }
  }
}

void note_steps(SensorWindow& window) {
  const auto& clock_step = window.result.clock_step;
  for (FrameReport& frame : window.frames) {
    if (frame.t_ns == window.result.bias_step_ns || (clock_step && frame.t_ns == clock_step->before_ns)) {
      frame.inputs.status = InputStatus::kContradicted;
      frame.inputs.contradiction = InputContradiction{};
    }
  }
}

}  // namespace

StartReport report_of(const SensorStartResult& result, const StartReport& of_last_frame) {
  StartReport out = of_last_frame.status == StartStatus::kWaiting ? result.report : of_last_frame;
  out.tilt_sigma = result.report.tilt_sigma;
  out.scale_sigma = result.report.scale_sigma;
  out.missing = result.report.missing;
  return out;
}

SensorWindow start_from_sensors(const SensorData& sensors, const RunSetup& setup, const FrameSource& source,
                                std::size_t first, const RunCallbacks& callbacks, bool shared) {
  const MotionModel motion = setup.navigator.motion;
  StartOptions options;
  const double duration_s =
      seconds_between(frame_time(sensors, first), frame_time(sensors, frame_count(sensors) - 1));
  options.longest_s = std::min(options.longest_s, kLongestShare * duration_s);
  const double most_s =
      std::max(options.longest_s, std::min(kLongestMovingShare * duration_s, duration_s - kLeastFiltered));
  options.longest_moving_s = std::min(options.longest_moving_s, most_s);
  options.longest_still_s = most_s;  // nothing is lost by waiting where all frames are there
  options.longest_fine_s = std::min(options.longest_fine_s, kLongestShare * duration_s);
  SensorStart start(setup.navigator, setup.calibration, options);
  InputFeed feed(sensors);
  SensorWindow out;
  std::vector<ReadFrame> seen;
  std::size_t n = first;
  while (n < frame_count(sensors) && out.report.status == StartStatus::kWaiting) {
    if (callbacks.stop && callbacks.stop()) {
      out.stopped = true;
      break;
    }
    seen.push_back(read_frame(source, n++));
    const StereoFrame& frame = seen.back().frame;
    const auto begin = Clock::now();
    feed.feed(start, motion, frame.t_ns + start.clock_offset_ns());
    out.report = start.add_frame(frame);
    FrameReport report;
    report.t_ns = frame.t_ns;
    report.observed = frame.observations.size();
    report.inputs = out.report.inputs;
    out.frames.push_back(report);
    out.frame_ms.push_back(milliseconds(begin, Clock::now()));
    if (callbacks.wait && out.report.status == StartStatus::kWaiting)
      callbacks.wait({frame, out.report, out.frames.size()});
  }
  if (out.frames.empty()) return out;  // stopped
  const auto begin_handing_over = Clock::now();
  out.result = start.result();
  if (const auto other = shared ? counterpart(setup) : std::nullopt) {
    out.counterpart = start.result_for(*other);
  }
  out.frame_ms.back() += milliseconds(begin_handing_over, Clock::now());
  out.of_last_frame = out.report;
  out.report = report_of(out.result, out.of_last_frame);
  keep_used(motion == MotionModel::kOdometry ? 0 : out.result.trajectory.size(), std::move(seen), out);
  note_steps(out);
  if (motion != MotionModel::kOdometry && !out.stopped && out.ahead.empty()) {
    out.smoothing =
        std::make_shared<StartSmoothing>(std::move(start), feed, motion, frame_time(sensors, first));
  }
  return out;
}

}  // namespace limber::detail
