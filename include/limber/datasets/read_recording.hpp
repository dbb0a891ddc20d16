// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "limber/datasets/recording.hpp"

namespace limber {

/// @brief Reads a recording; its content tells the format.
///
/// | format | recognised by | body | frames or images |
/// | --- | --- | --- | --- |
/// | track log | mav0/tracks0 | imu | frames |
/// | EuRoC with images | mav0/cam0/data.csv | imu | images |
/// | KITTI odometry | image_0 or image_2, or calib.txt and times.txt | cam0 | images |
///
/// Without cam0/sensor.yaml the calibration is that of dso/camchain.yaml and dso/imu_config.yaml (TUM-VI),
/// and mocap0 holds the truth. Colour images of KITTI (image_2, image_3) are taken where there are no grey
/// ones. `path` holds mav0 or is mav0 itself. EuRoC's T_BS is T_imu_cam0; theta follows from the T_BS of both
/// cameras. A track log without IMU and odometry whose T_BS of cam0 is exactly the identity has the left
/// camera as body. KITTI's world (first camera: x right, y down, z forward) is turned to z up, the first
/// camera looks along x; poses come from poses.txt or from ../../poses/NAME.txt. Noise that the files do not
/// give stays empty, and `notes` says so, as it does when stereo images without partner are left out.
///
/// @throws DataError with file, line, what was expected and what was found: nothing recognised, files or
/// folders
///         missing, wrong number of columns, numbers that are none or not finite, times that do not increase,
///         a point twice in a frame, unknown camera model or distortion, T_BS that is no rigid transform, a
///         baseline of zero or with cam1 to the left, image size other than the calibration's, no frame at
///         all, broken YAML.
[[nodiscard]] Recording read_recording(const std::filesystem::path& path);

}  // namespace limber
