// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "limber/diagnose/health_summary.hpp"
#include "limber/diagnose/time_offset.hpp"
#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

namespace limber {

/// What a recording shows of its clocks, and what its calibration says of them.
struct ClockOffsets {
  /// of cam1 against cam0, and of the cameras against the IMU; nothing where the recording does not show it
  std::optional<TimeOffset> cam1, cameras;
  double assumed_cam1 = 0.0, assumed_cameras = 0.0;  ///< the same by StereoCalibration::time_offset_s [s]
};

/// Both offsets. @param calibration  with the rig as found: a wrong rig is no wrong clock
[[nodiscard]] ClockOffsets clock_offsets(const StereoCalibration& calibration,
                                         std::span<const StereoFrame> frames, std::span<const ImuSample> imu);

/// @brief Clocks that are not as assumed, in words: off by more than 1 ms (cam1) or 3 ms (IMU) and by more
/// than 5 sigma. From few seconds sigma itself is hardly known, so that by Student's law chance must not do
/// the same once in ten thousand recordings: 17 sigma from five seconds, 8 from eight.
[[nodiscard]] std::vector<std::string> clock_mistakes(const ClockOffsets& clocks);

/// @brief The verdict on a rig beside clocks that are off. `ok` becomes `cannot tell`: an offset is part of
/// the calibration. `degraded` and `decalibrated` do so if it may be the clock: that of cam1 looks like a rig
/// that bends while it moves; that of the IMU bends the trajectory, and with it what motion says of depths,
/// so of vergence and the baseline's length. But it never moves a point off its epipolar line, by which the
/// other four axes, and a rig that moves, are judged as before.
[[nodiscard]] HealthVerdict verdict_beside(const ClockOffsets& clocks, const HealthSummary& health);

/// Where verdict_beside is not that of the rig.
inline constexpr const char* kClocksHideRig =
    "the rig is not judged: a clock that is off looks like a rig that is wrong, or hides one";

/// What to do about a clock that is off.
inline constexpr const char* kClockAdvice =
    "mend the clock (or give its offset: timeshift_cam_imu of a Kalibr file, --calib), and look again; until "
    "then --estimate dt0,dt1";

}  // namespace limber
