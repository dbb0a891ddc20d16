// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "limber/sensors/calibration.hpp"

/// @file
/// Calibrations in the formats of others. Numbers keep all digits (omni's focal lengths up to the last bit).
/// All but KITTI's calib.txt say the same; read_rig_file reads each of them back. They throw
/// std::invalid_argument if a number is not finite, the body is kMiddleOfBaseline, or the format has no word
/// for a lens. EuRoC's sensor.yaml has one for every lens.
namespace limber {

/// EuRoC's camN/sensor.yaml. @param camera  0 or 1
[[nodiscard]] std::string euroc_sensor_yaml(const StereoCalibration& calibration, int camera);

/// Kalibr's camchain.yaml; with T_cam_imu and timeshift_cam_imu where the body is the IMU. Knows no rational
/// lens.
[[nodiscard]] std::string kalibr_camchain(const StereoCalibration& calibration);
/// Kalibr's imu.yaml.
[[nodiscard]] std::string kalibr_imu(const ImuNoise& noise);

/// What stereoCalibrate and stereoRectify leave: size, M1, D1, M2, D2, R, T, R1, R2, P1, P2, Q; for
/// cv::FileStorage. `distortion_model: equidistant` marks coefficients of cv::fisheye. Knows no omni lens,
/// an equidistant one for both cameras only, and one size of images.
[[nodiscard]] std::string opencv_stereo_yaml(const StereoCalibration& calibration);

/// KITTI odometry's calib.txt (P0, P1): of images that were rectified with R1, R2, P1, P2 of
/// opencv_stereo_yaml, or R_rect and P_rect of kitti_cam_to_cam.
[[nodiscard]] std::string kitti_calib(const StereoCalibration& calibration);
/// KITTI raw's calib_cam_to_cam.txt. Knows radial-tangential lenses of up to five coefficients.
[[nodiscard]] std::string kitti_cam_to_cam(const StereoCalibration& calibration);

/// All names that write_rig_files may write, relative to its folder.
[[nodiscard]] std::vector<std::string> rig_file_names();

/// Which of camchain.yaml, stereo.yml and calib_cam_to_cam.txt write_rig_files leaves out, and why: a
/// sentence each.
[[nodiscard]] std::vector<std::string> rig_files_left_out(const StereoCalibration& calibration);

/// @brief All of them that can say it: cam0/sensor.yaml, cam1/sensor.yaml, camchain.yaml, imu.yaml (with
/// noise), stereo.yml, calib.txt and calib_cam_to_cam.txt.
/// @return the names, relative to `folder`, which exists
[[nodiscard]] std::vector<std::string> write_rig_files(const std::filesystem::path& folder,
                                                       const StereoCalibration& calibration,
                                                       const std::optional<ImuNoise>& noise);

}  // namespace limber
