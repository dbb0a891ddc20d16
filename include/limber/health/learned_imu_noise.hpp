// SPDX-License-Identifier: MIT
#pragma once

#include "limber/health/pose_correction.hpp"
#include "limber/sensors/calibration.hpp"

namespace limber {

/// @brief The noise of an IMU beside what its data sheet says.
///
/// What an IMU errs by that nobody models (a scale that is off, axes that are askew, vibration, stamps that
/// jitter) shows in how images correct the prediction. Whitened, and averaged over some ten frames,
/// corrections have the size that is expected of them, or the inputs are noisier than assumed: then their
/// densities are raised, slowly, until the size is right, and lowered again where it is small. A fault is
/// larger than any noise and shows at once: frames in which one is active are not for this class.
/// @note docs/derivations/faults.md
class LearnedImuNoise {
 public:
  /// From 1 to 100: no IMU is better than stated, and what is worse is broken.
  [[nodiscard]] static ImuNoiseFactors bounded(const ImuNoiseFactors& factors);

  /// @param begin  what a start has learned
  explicit LearnedImuNoise(const ImuNoiseFactors& begin = {});

  /// A correction of a pose that was predicted with the noise that was assumed, `factors()`.
  /// @param trusts_length  a length of the baseline that is wrong would move the position, too: the
  /// accelerometer is taken to be no noisier than the start, whose rig was free, found either sensor
  void learn(const PoseCorrection& correction, bool trusts_length = false);

  /// To be assumed; at least 1.
  [[nodiscard]] ImuNoiseFactors factors() const { return factors_; }

 private:
  ImuNoiseFactors begin_, factors_;
  RecentCorrections corrections_;
};

}  // namespace limber
