// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>

#include "limber/health/pose_correction.hpp"

namespace limber {

/// What the images say that the inputs were off by.
struct InputContradiction {
  double turn = 0.0;       ///< [rad], within a frame
  double shift = 0.0;      ///< [m]
  double dt = 0.0;         ///< [s] of that frame
  double statistic = 0.0;  ///< chi-square of 6 degrees of freedom
};

/// @brief Do the images contradict the inputs? A frame's correction of the pose is zero on average, with a
/// known covariance, if the prediction was what it says of itself.
///
/// Two tests: each frame's correction, and the fading mean of the whitened corrections of some ten frames,
/// which sees a small bias. Both are measured against the noise that the frame's other rows show (NIS / dof),
/// if that is larger than assumed, with room for inputs that are noisier than their data sheet says and for
/// pixel errors that stay while a track lives. For a filter that no calibration can lead astray.
/// @note docs/derivations/faults.md
class InputAlarm {
 public:
  /// @return whether a test rejects; then `found` says by how much
  [[nodiscard]] bool judge(const PoseCorrection& correction, InputContradiction& found);

  /// A test rejected less than `kCalm` seconds ago, or the last frame alone is doubtful (one of a thousand
  /// sound ones is): a fault begins to show before it is proven.
  [[nodiscard]] bool active(std::int64_t t_ns) const;

  /// Of the last frame: chi-square, 6 degrees of freedom, the larger of both tests; 0 before the first.
  [[nodiscard]] double statistic() const { return statistic_; }

  static constexpr double kCalm = 2.0;          ///< [s]
  static constexpr double kFalseAlarms = 1e-7;  ///< per frame and test

 private:
  RecentCorrections corrections_;
  double statistic_ = 0.0;
  bool doubtful_ = false;
  std::int64_t last_ns_ = std::numeric_limits<std::int64_t>::min();
};

}  // namespace limber
