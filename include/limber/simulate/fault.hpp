// SPDX-License-Identifier: MIT
#pragma once

#include <variant>

/// What goes wrong with sensors, on top of noise and dropouts. Times and durations are seconds, times count
/// from the start of the recording; a fault with a duration holds at t in [at, at + duration).
namespace limber {

/// A step of the gyroscope's bias, in a random direction. It is part of the truth's biases.
struct GyroBiasStep {
  double at = 0.0;    ///< [s]
  double size = 0.0;  ///< [rad/s]
};

/// A step of the accelerometer's bias, in a random direction. It is part of the truth's biases.
struct AccelBiasStep {
  double at = 0.0;    ///< [s]
  double size = 0.0;  ///< [m/s^2]
};

/// The accelerometer is hit: the first sample from `at` on, in a random direction.
struct ImuSpike {
  double at = 0.0;    ///< [s]
  double size = 0.0;  ///< added [m/s^2]
};

/// No component of any sample is larger than the range.
struct ImuSaturation {
  double accel = 0.0;  ///< [m/s^2]
  double gyro = 0.0;   ///< [rad/s]
};

/// Samples come with times of their own and the values of the last one before.
struct ImuStuck {
  double at = 0.0;        ///< [s]
  double duration = 0.0;  ///< [s]
};

/// No IMU samples.
struct ImuGap {
  double at = 0.0;        ///< [s]
  double duration = 0.0;  ///< [s]
};

/// The IMU's clock jumps against the cameras': samples from `at` on are stamped `size` later. Those that
/// would not be stamped later than the one before, or before the start, are lost.
struct ClockStep {
  double at = 0.0;    ///< [s]
  double size = 0.0;  ///< [s], may be negative
};

/// Right images that are older than the left ones they come with.
struct RightLate {
  double at = 0.0;        ///< [s]
  double duration = 1e6;  ///< [s]
  double delay = 0.0;     ///< [s]; nothing is older than the recording
};

/// Frames come with times of their own and the pixels of the last one before.
struct FramesRepeated {
  double at = 0.0;        ///< [s]
  double duration = 0.0;  ///< [s]
};

/// No stereo frames.
struct FrameGap {
  double at = 0.0;        ///< [s]
  double duration = 0.0;  ///< [s]
};

/// In the order in which they act, whatever the order of a list: a spike saturates, a stuck sample has a gap.
using Fault = std::variant<GyroBiasStep, AccelBiasStep, ImuSpike, ImuSaturation, ImuStuck, ImuGap, ClockStep,
                           RightLate, FramesRepeated, FrameGap>;

}  // namespace limber
