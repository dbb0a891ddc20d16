// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "limber/navigate/navigator.hpp"

/// @file
/// What a whole run says of its calibration: the reduction of its windows.
namespace limber {

/// A run's calibration, stretch by stretch.
struct HealthSummary {
  /// Of the present state. Where that is `ok`, and the rig came back from degraded or decalibrated at least
  /// twice, `degraded`: it comes and goes.
  HealthVerdict verdict = HealthVerdict::kCannotTell;
  CalibrationState present;            ///< since the last change
  std::vector<CalibrationState> past;  ///< the stretches before, in order
  std::int64_t begin_ns = 0;           ///< first frame

  /// Since the first frame [s].
  [[nodiscard]] double seconds(std::int64_t t_ns) const;
  /// `ok` now, and back from degraded or decalibrated at least twice.
  [[nodiscard]] bool comes_and_goes() const;
  /// `verdict`, by what is present and past.
  [[nodiscard]] HealthVerdict by_states() const;
  /// Degraded or decalibrated, before the present state.
  [[nodiscard]] bool was_wrong() const;
};

/// @return nothing if no window was judged
[[nodiscard]] std::optional<HealthSummary> summarize_health(std::span<const FrameReport> frames);

/// As in summary.json, degrees and mm: docs/formats-health.md.
[[nodiscard]] std::string to_json(const HealthSummary& summary, const WatchOptions& options);

/// "vergence, about y" for ay.
/// @param vergence  vergence_axis() of the rig
[[nodiscard]] std::string_view axis_in_words(std::size_t axis, Eigen::Index vergence);

/// The verdict in one sentence, with the sizes that it rests on.
[[nodiscard]] std::string in_words(const HealthSummary& summary, const Tolerance& tolerance);

/// @brief What to do about a verdict, in plain words.
/// @param moves  the cameras move against each other (CalibrationState::moves)
[[nodiscard]] std::string advice_on(HealthVerdict verdict, bool moves);

/// The same where rows are not exposed as assumed, so that nothing is said of the rig.
inline constexpr const char* kReadoutAdvice =
    "say how long an image takes (--readout-time, or readout_time in sensor.yaml), and look again";

/// @brief The verdict on how the rig moved from one recording to the next, in one sentence, see
/// change_between.
[[nodiscard]] std::string change_in_words(const CalibrationState& change, const Tolerance& tolerance);

/// As `since` of `limber health --json`, degrees and mm: docs/formats-health.md.
[[nodiscard]] std::string change_json(const CalibrationState& change, const Tolerance& tolerance);

/// From radians and metres to degrees and millimetres.
[[nodiscard]] RigParameters in_degrees_and_mm(const RigParameters& theta);

}  // namespace limber
