// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "limber/navigate/navigator_options.hpp"
#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"
#include "limber/state/state.hpp"

/// @file
/// What images and IMU together say of what a filter takes for exact between them: how cam0 sits on the IMU,
/// scale and axes of the accelerometer, scale of the gyro, the clock. A score test (Lagrange multipliers) by
/// the least-squares problem of a start: docs/derivations/start.md.
namespace limber {

/// What is taken for exact. Offsets are true minus assumed.
enum class InertialFactor : std::uint8_t {
  kMountTurn,   ///< of cam0 on the body, R_true = exp(turn) R_assumed, in body axes [rad]
  kLeverArm,    ///< where cam0 stands on the body, in body axes [m]
  kAccelScale,  ///< how much more than its samples say the accelerometer saw, as a share of it
  kAccelTurn,   ///< of the accelerometer's axes, f_true = exp(turn) f, in body axes [rad]
  kGyroScale,   ///< as kAccelScale, of the gyro
  kClock,       ///< how much later than stamped the cameras saw [s]
  kAccelScales  ///< as kAccelScale, of each axis
};

/// "mount", "lever arm", "accelerometer scale", "accelerometer axes", "gyro scale", "clock", "accelerometer
/// scales".
[[nodiscard]] std::string_view to_string(InertialFactor factor);

/// @brief What one stretch of a recording says of all these offsets, near zero: the log-likelihood, with all
/// else that is unknown at its best, is score' x - x' information x / 2. Of stretches that share no noise the
/// sums say it.
struct InertialEvidence {
  static constexpr Eigen::Index kOffsets = 14;      ///< of all factors, see directions_of
  static constexpr std::size_t kFewestFrames = 20;  ///< of a stretch
  Eigen::Matrix<double, kOffsets, kOffsets> information =
      Eigen::Matrix<double, kOffsets, kOffsets>::Zero();  ///< symmetric
  /// its other part
  Eigen::Matrix<double, kOffsets, 1> score = Eigen::Matrix<double, kOffsets, 1>::Zero();
  /// What the inputs are off by beside the best of all offsets: squared, in their stated noise, and how many
  /// degrees of freedom that has. Far more than one each is noise that nobody stated.
  double misfit = 0.0, dof = 0.0;

  /// The sum.
  InertialEvidence& operator+=(const InertialEvidence& other);
  /// Without one that was added.
  InertialEvidence& operator-=(const InertialEvidence& other);
};

/// @brief The offsets of one factor among all: kOffsets rows, a column for each; orthogonal. The
/// accelerometer's scale is that of its three axes alike.
[[nodiscard]] Eigen::MatrixXd directions_of(InertialFactor factor);

/// @brief Solves a stretch as a start does, with the rig free in every frame, from states that a filter
/// found, and asks it for the evidence. Pixels count as good as they show themselves from frame to frame.
/// @param options  with the IMU's noise as stated
/// @param frames   without mismatches that a cleaning can see, at their stamps; in order of time
/// @param imu      of all that time, in order of time
/// @param states   one for each frame
/// @return nothing where frames are fewer than kFewestFrames, or no motion fits
/// @throws std::invalid_argument as SensorStart, and if there are more or fewer states than frames
[[nodiscard]] std::optional<InertialEvidence> inertial_evidence(const NavigatorOptions& options,
                                                                const StereoCalibration& calibration,
                                                                std::span<const StereoFrame> frames,
                                                                std::span<const ImuSample> imu,
                                                                std::span<const NavigationState> states);

}  // namespace limber
