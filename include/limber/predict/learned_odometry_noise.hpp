// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <deque>

#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

namespace limber {

/// @brief The noise of odometry where nobody stated it.
///
/// A vehicle's velocity and rate change smoothly from sample to sample, white noise does not: the third
/// difference of four samples is nothing for a quadratic, and its variance is 20 times that of white noise.
/// What the vehicle does faster than that is taken for noise. Differences do not show what lasts, such as the
/// size of a wheel: 1 % of the speed for ten samples is as bad as white noise of 3 %, which is assumed
/// beside.
/// A coordinate that is never but zero is not measured (wheels know nothing of sideways, up, roll and pitch):
/// what was assumed at first stays. Nor is anything learned at rest, of which encoders have no noise.
/// @note docs/evidence/real-data.md
class LearnedOdometryNoise {
 public:
  static constexpr double kLasting = 0.03;  ///< of the speed [-]

  /// @param begin  assumed until some twenty samples have told better
  explicit LearnedOdometryNoise(const OdometryNoise& begin) : begin_(begin) {}

  /// Samples in the order of time; a gap begins anew, and keeps what is known.
  void add(const OdometrySample& sample);

  /// White, per sample [m/s, rad/s].
  [[nodiscard]] OdometryNoise white() const;
  /// Per sample at a speed [m/s]: to be assumed.
  [[nodiscard]] OdometryNoise assumed(double speed) const;
  /// The same at the speed of the last sample.
  [[nodiscard]] OdometryNoise assumed() const;
  /// Enough samples have been seen.
  [[nodiscard]] bool knows() const { return differences_ >= kEnough; }

 private:
  static constexpr int kEnough = 20;
  using Vector6 = Eigen::Matrix<double, 6, 1>;

  void learn(const Vector6& third_difference);
  [[nodiscard]] bool evenly_spaced() const;
  [[nodiscard]] bool rests() const;

  OdometryNoise begin_;
  std::deque<OdometrySample> last_;  // four at most
  Vector6 variance_ = Vector6::Zero();
  std::array<bool, 6> measured_{};  // whether it ever was not zero
  int differences_ = 0;
};

}  // namespace limber
