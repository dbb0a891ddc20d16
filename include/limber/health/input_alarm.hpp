// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>

#include "limber/health/pose_correction.hpp"

namespace limber {

/// What the images say that the inputs were off by.
struct InputContradiction {
  double turn = 0.0;       ///< [rad], within a frame
  double shift = 0.0;      ///< [m]
  double dt = 0.0;         ///< [s] of that frame
  double statistic = 0.0;  ///< chi-square of 6 degrees of freedom
  /// If steps of an IMU's biases explain it, those: gyro [rad/s], accelerometer [m/s^2].
  std::optional<Eigen::Matrix<double, 6, 1>> bias_step{};
};

/// Steps of an IMU's biases that explain the innovations since some time best.
struct BiasStepFit {
  double explained = 0.0;            ///< by so much they lower the NIS of all of them
  double factor = 1.0;               ///< by which another reason (a rig that bends) may make it larger
  Eigen::Matrix<double, 6, 1> step;  ///< gyro [rad/s], accelerometer [m/s^2]
};

/// @brief Do the images contradict the inputs? A frame's correction of the pose is zero on average, with a
/// known covariance, if the prediction was what it says of itself.
///
/// Two tests: each frame's correction, and the fading mean of the whitened corrections of some ten frames,
/// which sees a small bias. Both are measured against the noise that the frame's other rows show (NIS / dof),
/// if that is larger than assumed, with room for inputs that are noisier than their data sheet says and for
/// pixel errors that stay while a track lives. A third test is of steps of the biases. For a filter that no
/// calibration can lead astray.
/// @note docs/derivations/faults.md
class InputAlarm {
 public:
  /// @return whether a test rejects; then `found` says by how much
  [[nodiscard]] bool judge(const PoseCorrection& correction, InputContradiction& found);

  /// @brief The same of steps of the biases, after judge() of the same frame: a likelihood ratio test of a
  /// jump, which grows with every frame that it lasts. Not while an older contradiction is active: then the
  /// state is wide open, and anything fits.
  [[nodiscard]] bool judge_step(const PoseCorrection& correction, const BiasStepFit& fit,
                                InputContradiction& found);

  /// A test rejected less than `kCalm` seconds ago, or the last frame alone is doubtful (one of a thousand
  /// sound ones is): a fault begins to show before it is proven.
  [[nodiscard]] bool active(std::int64_t t_ns) const;

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
