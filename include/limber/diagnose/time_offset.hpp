// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <optional>
#include <span>

#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

/// @file
/// Clocks that disagree look like a rig that bends while it moves. That of cam1 is found by least squares
/// with Huber weights over a whole recording, apart from any filter; that of both cameras in
/// cameras_beside_imu.hpp.
namespace limber {

/// How much later than stamped something was taken, and its standard deviation [s].
struct TimeOffset {
  /// how much later than stamped [s], and its standard deviation
  double seconds = 0.0, sigma = 0.0;
  /// of sigma, in the sense of Student's law: a sigma from few seconds is itself hardly known
  double dof = std::numeric_limits<double>::infinity();
};

/// @brief Of cam1 against cam0. A right pixel that is late by tau is off by tau times its velocity; across
/// its epipolar line no depth can explain that. Beside tau, the five parameters of the rig are estimated that
/// move points across it (all but the baseline's length), so that a wrong calibration is none of the clock.
/// The left pixel's velocity is the instrument of the right one's, which is as noisy as the residual is
/// small, and the point between the frames beside that of the point itself, whose noise is in the residual.
/// Every four seconds have a rig of their own: one that jumps or drifts while it moves looks like an offset.
/// To first order; where that is three sigmas or 10 ms, Gauss-Newton in the rig and in time, for a rig that
/// is off by degrees or a picture that is late by a frame is not linear. Right bearings are then taken from
/// along the line to the next frame.
/// @return nothing with fewer than 200 points that were followed through three frames, or where the motion
/// does not tell them apart. sigma counts a track's residuals as one draw: they are alike along a track, with
/// the degrees of freedom of the tracks that tell.
[[nodiscard]] std::optional<TimeOffset> cam1_time_offset(const StereoCalibration& calibration,
                                                         std::span<const StereoFrame> frames);

}  // namespace limber
