// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "limber/health/pose_correction.hpp"

namespace limber {

/// How large steps of an IMU's biases are, each a root of the sum of squares, and of its clock.
struct StepSize {
  double gyro = 0.0;   ///< [rad/s]
  double accel = 0.0;  ///< [m/s^2]
  double clock = 0.0;  ///< [s]
};

/// What the images say that the inputs were off by.
struct InputContradiction {
  double turn = 0.0;       ///< [rad], within a frame
  double shift = 0.0;      ///< [m]
  double dt = 0.0;         ///< [s] of that frame
  double statistic = 0.0;  ///< chi-square of 6 degrees of freedom
  /// If steps of an IMU's biases and clock explain it, and no single frame does.
  std::optional<StepSize> step{};
  /// If it is known by now that an IMU's clock has stepped: how much later than taken its samples are stamped
  /// [ns]. They are used so from then on.
  std::optional<std::int64_t> clock_offset_ns{};
  /// If `step` explains it and the filter trusts the rig, which made it wait: since when its sigmas may be
  /// too small [ns].
  std::optional<std::int64_t> astray_since_ns{};
};

/// Steps of an IMU that explain the innovations since some time best.
struct StepFit {
  double explained = 0.0;           ///< by so much they lower the NIS of all of them
  double explained_by_clock = 0.0;  ///< by so much that of the clock does alone
  double factor = 1.0;              ///< by which another reason (a rig that bends) may make them larger
  StepSize size{};                  ///< of them, with their standard deviation
};

/// @brief Do the images contradict the inputs? A frame's correction of the pose is zero on average, with a
/// known covariance, if the prediction was what it says of itself.
///
/// Three tests: each frame's correction; the fading mean of the whitened corrections of some ten frames,
/// which sees a small bias; and the likelihood ratio of a jump of the biases and the clock, which grows with
/// every frame that it lasts. All are measured against the noise that the frame's other rows show (NIS /
/// dof), if that is larger than assumed, with room for inputs that are noisier than their data sheet says and
/// for pixel errors that stay while a track lives. For a filter that no calibration can lead astray.
/// @note docs/derivations/faults.md
class InputAlarm {
 public:
  /// @brief One frame.
  /// @param fit  not looked at while an older contradiction is active: a state that is wide open fits
  /// anything
  /// @return whether a test rejects; then `found` says by how much
  [[nodiscard]] bool judge(const PoseCorrection& correction, const StepFit& fit, InputContradiction& found);

  /// A test rejected less than `kCalm` seconds ago, or the last frame alone is doubtful (one of a thousand
  /// sound ones is): a fault begins to show before it is proven.
  [[nodiscard]] bool active(std::int64_t t_ns) const;

  /// The last frame's points contradict each other, as those of a body that begins to move do: what they say
  /// of anything else is worth less.
  [[nodiscard]] bool points_quarrel() const { return corrections_.points_quarrel(); }

  /// Of the last frame: chi-square, 6 degrees of freedom, the largest of the tests; 0 before the first.
  [[nodiscard]] double statistic() const { return statistic_; }

  static constexpr double kCalm = 2.0;          ///< [s]
  static constexpr double kFalseAlarms = 1e-7;  ///< per frame and test

 private:
  [[nodiscard]] bool contradicted(std::int64_t t_ns) const;

  RecentCorrections corrections_;
  double statistic_ = 0.0;
  bool doubtful_ = false;
  std::int64_t last_ns_ = std::numeric_limits<std::int64_t>::min();
};

}  // namespace limber
