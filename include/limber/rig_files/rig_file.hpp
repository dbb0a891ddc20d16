// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "limber/sensors/calibration.hpp"

/// @file
/// Calibrations of stereo rigs as calibration tools write them. Foreign conventions end here.
namespace limber {

/// Which images a calibration belongs to.
enum class ImageKind : std::uint8_t {
  kRaw,       ///< as the camera gives them
  kRectified  ///< undistorted and turned, so that rows correspond
};

/// "raw", "rectified".
[[nodiscard]] std::string to_string(ImageKind kind);

/// What a file says of a stereo rig, in limber's own conventions.
struct RigFile {
  std::string format;  ///< "Kalibr camchain", "EuRoC sensor.yaml", ...
  /// body: kImu if the file places the cameras on an IMU, else kCam0. Width and height 0: the file does not
  /// say.
  StereoCalibration calibration;
  /// continuous densities; nothing: the file does not say
  std::optional<ImuNoise> imu_noise;
  /// which images it belongs to
  ImageKind images = ImageKind::kRaw;
  std::vector<std::string> notes;  ///< what was chosen or left out, in plain words
};

/// @brief Reads a calibration; its content tells the format.
///
/// | format | recognised by | images |
/// | --- | --- | --- |
/// | EuRoC sensor.yaml | a folder with (mav0/)cam0/sensor.yaml and cam1/sensor.yaml | raw |
/// | cuVSLAM's sensor_cam0.yaml, sensor_cam1.yaml, sensor_imu0.yaml | a folder with them | raw |
/// | Kalibr camchain (also OpenVINS') | cam0: and cam1: with intrinsics | raw |
/// | OpenCV stereoCalibrate, stereoRectify | M1, D1, M2, D2, R, T; or P1, P2 | raw, rectified |
/// | Basalt | JSON with value0 | raw |
/// | KITTI odometry calib.txt | P0: and P1: | rectified |
/// | KITTI raw calib_cam_to_cam.txt | K_00: and P_rect_00: | raw, rectified |
///
/// Lenses that limber has not (double sphere, EUCM, more than eight coefficients) are replaced by the
/// radial-tangential (k1, k2, p1, p2) or equidistant one that fits best over the whole image, if it fits to
/// 0.1 px everywhere; `notes` says how well.
///
/// @param images  which of the two, where a file holds both
/// @throws DataError with file, line, what was expected and what was found
[[nodiscard]] RigFile read_rig_file(const std::filesystem::path& path,
                                    std::optional<ImageKind> images = std::nullopt);

/// @brief Noise densities of a Kalibr imu.yaml (top level, or below imu0 as in OpenVINS).
/// @throws DataError also if it says that the samples need a correction first (time_offset, T_i_b, Tw, Ta,
/// Tg, R_IMUtoGYRO, R_IMUtoACC)
[[nodiscard]] ImuNoise read_kalibr_imu(const std::filesystem::path& path);

}  // namespace limber
