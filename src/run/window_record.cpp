// SPDX-License-Identifier: MIT
#include "window_record.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "limber/core/angle.hpp"
#include "limber/core/time.hpp"
#include "limber/navigate/navigator.hpp"
#include "limber/run/trajectory_row.hpp"

namespace limber::detail {
namespace {

constexpr double kClockMatters = 1e-3;  // [s]
constexpr double kClockSurely = 5.0;    // of its sigma

/// How long it took, what is known, and what is not.
void say_start(const SensorWindow& window, RunRecord& record) {
  const StartReport& report = window.report;
  if (!window.result.solved) {
    record.notes.push_back(
        fmt::format("no start was found in the first {:.2g} s, of which no pose is known: {}",
                    report.waited_s, report.missing));
    return;
  }
  record.notes.push_back(fmt::format(
      "{}{:.2g} s, which are smoothed: {}{}{}",
      report.status == StartStatus::kWaiting ? "nothing but a start, all " : "started from the first ",
      report.waited_s,
      report.tilt_sigma > 0.0 ? fmt::format("tilt known to {:.2g} deg, ", report.tilt_sigma * kToDegrees)
                              : "",
      report.scale_sigma < 1.0 ? fmt::format("scale to {:.2g} %", 100.0 * report.scale_sigma)
                               : "scale not at all",
      report.missing.empty() ? "" : "; not known: " + report.missing));
  say_clock(record, record.notes);
}

}  // namespace

void say_clock(const RunRecord& record, std::vector<std::string>& notes) {
  const auto& jump = record.clock_step_of_start;
  const double offset_s = to_seconds(jump ? jump->offset_ns : record.start.clock_offset_ns);
  const double sigma_s = record.start.clock_sigma;
  const char* const when = offset_s > 0.0 ? "earlier" : "later";
  if (jump) {
    notes.push_back(fmt::format(
        "the IMU's clock stepped between {:.3f} s and {:.3f} s: its samples since then were taken {:.4f} s "
        "{} than they are stamped, and are used so",
        to_seconds(jump->after_ns), to_seconds(jump->before_ns), std::abs(offset_s), when));
  } else if (std::abs(offset_s) > std::max(kClockMatters, kClockSurely * sigma_s)) {
    notes.push_back(fmt::format(
        "the IMU's samples were taken {:.4f} s {} than they are stamped, by the images (±{:.4f} s), and are "
        "used so (--imu-clock learned)",
        std::abs(offset_s), when, sigma_s));
  }
}

void write_states(const std::vector<SmoothedState>& states, RunRecord& record) {
  for (std::size_t k = 0; k < states.size(); ++k) {
    const SmoothedState& state = states[k];
    record.trajectory[k] =
        trajectory_row(state.nav, record.motion, state.pose_covariance, state.motion_covariance);
  }
}

std::vector<SmoothedState> smoothed_ahead(const FrameSource& source, std::size_t next, std::size_t count,
                                          SensorWindow& window, WindowSmoother& smoother) {
  for (std::size_t n = next; n < count && window.smoothing && !window.smoothing->complete(); ++n) {
    window.ahead.push_back(read_frame(source, n));
    smoother.add(window.ahead.back().frame);
  }
  return smoother.states();
}

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
  say_start(window, record);
}

}  // namespace limber::detail
