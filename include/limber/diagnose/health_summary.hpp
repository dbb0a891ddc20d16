// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "limber/navigate/navigator.hpp"

/// @file
/// What a whole run says of its calibration: the reduction of the monitor's reports.
namespace limber {

/// An error of the rig, true minus assumed theta [rad, m], and its standard deviation.
struct RigOffset {
  RigParameters delta = RigParameters::Zero();
  RigParameters sigma = RigParameters::Zero();
};

/// What the monitor found over a whole run.
struct HealthSummary {
  HealthVerdict verdict = HealthVerdict::kCannotTell;
  std::array<HealthVerdict, 6> axes{};  ///< ax, ay, az, tx, ty, tz
  std::optional<double> first_alarm_s;  ///< since the first frame [s]; nothing without an alarm
  std::optional<double> changed_s;      ///< since when, as the first alarm has it [s]
  RigOffset mean;                       ///< over the windows of the whole recording
  RigOffset since_change;               ///< over those after changed_s; without an alarm the same as mean
  /// Of the first alarm. Without an alarm: the smallest of any window times their number, at most 1.
  double p_value = 1.0;
};

/// @brief One verdict, and one offset, for a run.
///
/// `decalibrated` if there was an alarm; else `suspect` if the last frame is, `ok` if an axis could be judged
/// in any window, `cannot tell` if none could. An axis is `decalibrated` if the monitor named it in at least
/// half of the decalibrated frames (where it kept to none: those of the first alarm), and `cannot tell` if it
/// never could be judged.
///
/// A window's estimate is the last report before the evidence is begun anew. Windows are averaged axis by
/// axis, weighted by 1 / sigma². Successive windows share the errors of pose and map, so sigma is the mean of
/// theirs with the same weights, and not divided by the root of their number.
/// @return nothing if no frame has a health report
[[nodiscard]] std::optional<HealthSummary> summarize_health(std::span<const FrameReport> frames);

/// The last report of each window: what it gathered.
[[nodiscard]] std::vector<HealthReport> windows_of(std::span<const HealthReport> reports);

/// As in summary.json, degrees and mm: docs/formats.md.
[[nodiscard]] std::string to_json(const HealthSummary& summary, double false_alarms_per_hour);

/// From radians and metres to degrees and millimetres.
[[nodiscard]] RigParameters in_degrees_and_mm(const RigParameters& theta);

}  // namespace limber
