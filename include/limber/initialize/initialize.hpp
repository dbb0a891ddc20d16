// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"
#include "limber/state/initial_state.hpp"

namespace limber {

/// What the first moments of a recording offer to start from. All from the first frame on.
struct StartWindow {
  std::span<const StereoFrame> frames;       ///< a second or so; at least one
  std::span<const ImuSample> imu;            ///< covers the frames; empty if there is no IMU
  std::span<const OdometrySample> odometry;  ///< covers the first frame; empty if there is none
};

/// @brief A start from sensors alone, at the first frame: the world's origin is the body, yaw is zero.
///
/// With IMU: gravity and velocity from the stereo motion of the window and the inertial samples between
/// (linear least squares), or, where the rig stands still, from the mean specific force and zero. Without:
/// the camera is taken to look horizontally, the velocity comes from the stereo motion. A velocity from
/// stereo motion inherits the assumed calibration's error, so that its uncertainty grows with the speed. Too
/// few common points: velocity zero, with an uncertainty that says so.
/// @param gravity  [m/s^2]
/// @throws std::invalid_argument if the window has no frame
[[nodiscard]] InitialState initialize(const StartWindow& window, const StereoCalibration& calibration,
                                      MotionModel motion, double gravity);

}  // namespace limber
