// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "limber/diagnose/cameras_beside_imu.hpp"
#include "limber/diagnose/health_summary.hpp"
#include "limber/diagnose/inertial_check.hpp"
#include "limber/diagnose/time_offset.hpp"
#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

namespace limber {

/// What a recording shows of its clocks and of the mount of its cameras, and what its calibration says of
/// them.
struct SensorOffsets {
  /// of cam1 against cam0, and of the cameras against the IMU; nothing where the recording does not show it
  std::optional<TimeOffset> cam1, cameras;
  double assumed_cam1 = 0.0, assumed_cameras = 0.0;  ///< the same by StereoCalibration::time_offset_s [s]
  double corrected_cameras = 0.0;         ///< by so much more a run found and took it, all along [s]
  std::optional<MountTurn> mount;         ///< of cam0 on the IMU; nothing as above
  double focal_widths = 0.0;              ///< focal length of cam0, in widths of its image
  std::vector<TurnScale> scales;          ///< as of CamerasBesideImu; none as above
  double confusion = 1.0;                 ///< as there
  std::optional<InertialCheck> inertial;  ///< of a run; nothing where none was asked, or none tells
};

/// What is wrong between cameras and IMU, and what to do about it.
struct OffsetMistake {
  std::string words;   ///< one sentence
  const char* advice;  ///< one clause
  /// What is learned of the IMU's noise is as large as the mistake: poses are as wrong as their sigmas say.
  bool sigmas_hold = false;
};

/// How much later than stamped a run took the cameras to see, by the IMU's clock and all along, beyond what
/// was assumed [s]; 0 where it found none, or a clock that jumped.
[[nodiscard]] double corrected_clock(const RunRecord& record);

/// All of them. @param calibration  with the rig as found: a wrong rig is no wrong clock
[[nodiscard]] SensorOffsets sensor_offsets(const StereoCalibration& calibration,
                                           std::span<const StereoFrame> frames,
                                           std::span<const ImuSample> imu);

/// @brief Clocks that are not as assumed, in words: off by more than 1 ms (cam1) or 3 ms (IMU) and by more
/// than 5 sigma. From few seconds sigma itself is hardly known, so that by Student's law chance must not do
/// the same once in ten thousand recordings: 17 sigma from five seconds, 8 from eight.
[[nodiscard]] std::vector<std::string> clock_mistakes(const SensorOffsets& offsets);

/// That of the cameras against the IMU among them; none where it is what a run has corrected.
[[nodiscard]] std::optional<std::string> imu_clock_mistake(const SensorOffsets& offsets);

/// A clock of the IMU that is off, as a run has corrected it, in words.
[[nodiscard]] std::optional<std::string> corrected_clock_in_words(const SensorOffsets& offsets);

/// @brief A mount that is turned against the calibration, in words: by more than 5 sigma as above, and by 0.4
/// deg, or more where cam0 has a lens that is longer than its image is wide (0.4 deg for each width). What a
/// lens model leaves (0.2 px rms) looks like up to 0.3 deg, and more with a narrow view: points to the sides
/// tell of a roll, the less the nearer they are to the middle. A principal point that is off looks like a
/// mount, too, and is named with it.
[[nodiscard]] std::optional<OffsetMistake> mount_mistake(const SensorOffsets& offsets);

/// "focal length", "gyro", "gyro x", ...
[[nodiscard]] std::string_view to_string(TurnFactor factor);

/// Of the factors by which cameras and gyro may turn unlike each other, the surest one; nothing where none is
/// told.
[[nodiscard]] std::optional<TurnScale> surest_scale(const SensorOffsets& offsets);

/// @brief Cameras that turn by more or less than the gyro says, in words: by more than 5 sigma as above, by
/// half a per cent, and by more than what a lens model leaves looks like: 0.2 % times the confusion (seen in
/// simulation with 0.2 px rms: up to 0.16 %). It names the surest factor, and others that explain it as well.
[[nodiscard]] std::optional<OffsetMistake> turn_scale_mistake(const SensorOffsets& offsets);

/// @brief Images and IMU that contradict each other by more than noise, in words: a factor that explains 12
/// times as much for each of its directions (of one: 20 times) as chance would, also without the stretch that
/// says most of it, and whose offset is 0.4 deg, 3 cm (both more for a lens as in mount_mistake), 0.5 % or
/// 0.5 deg (axes) at least: what a lens model leaves (0.2 px rms) looks like 0.3 deg or 2 cm. With it are
/// named those that explain 0.4 times as much, as a principal point makes them. None where a clock explains
/// more, nor what the others name already. Where the run found contradictions everywhere, and no stretch is
/// explained by any motion: that.
[[nodiscard]] std::optional<OffsetMistake> inertial_mistake(const SensorOffsets& offsets);

/// What the IMU and the cameras are not to each other as the calibration says, but for clocks: turns, the
/// mount, then what the inputs contradict beside these.
[[nodiscard]] std::vector<OffsetMistake> camera_imu_mistakes(const SensorOffsets& offsets);

/// @brief Whether turns that contradict each other are in the sigmas of a run: it took the gyro for much
/// noisier than stated, and nothing else, or its stretches do not contradict each other so (samples of the
/// gyro that were left out, say).
[[nodiscard]] bool turns_are_in_sigmas(const InertialCheck& check);

/// All of them in words: clocks, then the others.
[[nodiscard]] std::vector<std::string> offset_mistakes(const SensorOffsets& offsets);

/// @brief The verdict where the trajectory is wrong, and with it what motion says of depths: what epipolar
/// lines alone say where the rig is wrong by them, too; else `cannot tell`.
[[nodiscard]] HealthVerdict verdict_by_lines(const HealthSummary& health);

/// @brief The verdict on a rig beside clocks and other offsets of the IMU. The others leave it as it is, but
/// for `ok`, which becomes `degraded`: depths are right, poses are not.
///
/// Clocks that are off: `ok` becomes `cannot tell`: an offset is part of
/// the calibration. `degraded` and `decalibrated` do so if it may be the clock: that of cam1 looks like a rig
/// that bends while it moves; that of the IMU bends the trajectory, and with it what motion says of depths,
/// so of vergence and the baseline's length. But it never moves a point off its epipolar line, by which the
/// other four axes, and a rig that moves, are judged as before.
[[nodiscard]] HealthVerdict verdict_beside(const SensorOffsets& offsets, const HealthSummary& health);

/// Where verdict_beside is not that of the rig, because of a clock.
inline constexpr const char* kClocksHideRig =
    "the rig is not judged: a clock that is off looks like a rig that is wrong, or hides one";

/// What to do about a mistake of the calibration or of units.
inline constexpr const char* kMistakeAdvice = "mend the mistake, and look again";

/// What to do about a clock that is off.
inline constexpr const char* kClockAdvice =
    "mend the clock (or give its offset: timeshift_cam_imu of a Kalibr file, --calib), and look again; until "
    "then --imu-clock learned (the default) for the IMU's, --estimate dt0,dt1 for cam1's";

/// What to do about turns that a focal length explains best.
inline constexpr const char* kFocalAdvice =
    "calibrate the focal lengths of the cameras (or the scale of the gyro, if it is that); until then "
    "--estimate fu0,fv0,fu1,fv1";

/// What to do about turns that the gyro alone explains.
inline constexpr const char* kGyroScaleAdvice =
    "calibrate the scale of the gyro: limber takes its rates as they are";

/// What to do about images and IMU that contradict each other.
inline constexpr const char* kInertialAdvice =
    "measure where cam0 stands on the IMU (T_BS), and calibrate both; --estimate "
    "imu-tx=0.3,imu-ty=0.3,imu-tz=0.3,cu0,cv0,cu1,cv1 tells a lever arm from a principal point";

/// What to do about an accelerometer alone.
inline constexpr const char* kAccelAdvice =
    "calibrate the accelerometer (scale, and axes against the gyro): limber takes its samples as they are";

/// What to do about a mount that is turned.
inline constexpr const char* kMountAdvice =
    "calibrate the cameras against the IMU (T_BS; T_cam_imu of a Kalibr file, --calib); until then "
    "--estimate imu-ax,imu-ay,imu-az";

}  // namespace limber
