// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "limber/core/pose.hpp"
#include "limber/rig_files/rig_file.hpp"
#include "rig_files/foreign_cameras.hpp"
#include "rig_files/sensor_yaml.hpp"

/// The readers behind read_rig_file, one per format.
namespace limber::detail {

[[nodiscard]] RigFile read_euroc_rig(const std::filesystem::path& folder);
[[nodiscard]] RigFile read_cuvslam_rig(const std::filesystem::path& folder);
[[nodiscard]] RigFile read_kalibr_rig(const SensorYaml& yaml);
[[nodiscard]] RigFile read_opencv_rig(const SensorYaml& yaml, std::optional<ImageKind> images);
[[nodiscard]] RigFile read_basalt_rig(const SensorYaml& yaml);
/// The grey cameras (P0, P1), or the colour ones (P2, P3).
[[nodiscard]] RigFile read_kitti_odometry_rig(const std::filesystem::path& path, bool colour = false);
/// T_cam0_cam2: where the left colour camera stands, seen from the left grey one. Both are rectified.
[[nodiscard]] Pose kitti_colour_camera(const std::filesystem::path& path);
/// The grey cameras (00, 01) if the file has them, else the colour ones (02, 03); these also if `colour` is
/// set.
[[nodiscard]] RigFile read_kitti_raw_rig(const std::filesystem::path& path, std::optional<ImageKind> images,
                                         bool colour = false);
/// Width and height of the left images that read_kitti_raw_rig would take.
[[nodiscard]] std::pair<int, int> kitti_raw_size(const std::filesystem::path& path, ImageKind images,
                                                 bool colour);
/// T_imu_cam0 of the left camera that read_kitti_raw_rig takes, by calib_cam_to_cam.txt,
/// calib_velo_to_cam.txt and calib_imu_to_velo.txt in the folder.
[[nodiscard]] Pose kitti_camera_on_imu(const std::filesystem::path& folder, ImageKind images, bool colour);

/// Sets T_body_cam0, theta and the body from the places of the cameras on the IMU.
void place_on_imu(StereoCalibration& calibration, const Pose& T_imu_cam0, const Pose& T_imu_cam1);

/// @brief A camera of Mei's unified model, whose files have the focal lengths of limber's camera times 1 +
/// xi.
/// @param pinhole  with the file's focal lengths
/// @param key      where xi stands, for messages
/// @throws DataError if xi is not above -1
[[nodiscard]] Camera omni_camera(Camera pinhole, const Omni& lens, const SensorYaml& yaml,
                                 const std::string& key);

/// @brief A camera of limber's in place of a foreign one, and a note of how well it fits.
/// @param start  as fit_camera has it; width 0: the size of the image is not known
/// @param place, line  where it stands
/// @param name         whose it is
/// @throws DataError if the size is not known, or nothing fits to kWorstFit_px
[[nodiscard]] Camera fitted(const ForeignProjection& projection, const Camera& start,
                            const std::filesystem::path& place, std::size_t line, const std::string& name,
                            std::vector<std::string>& notes);
/// A pinhole camera with OpenCV's k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4 [tx ty]]]], as `fitted` where it
/// needs more than eight.
[[nodiscard]] Camera opencv_camera(Camera pinhole, const std::vector<double>& coefficients,
                                   const std::filesystem::path& place, std::size_t line,
                                   const std::string& name, std::vector<std::string>& notes);

/// What must hold of any rig before it is handed out: cameras apart, cam1 to the right.
void check_rig(RigFile& rig, const std::filesystem::path& file, std::size_t line, const std::string& hint);

/// Which of the two that a file holds. @throws DataError if nobody says
[[nodiscard]] ImageKind chosen(std::optional<ImageKind> images, const std::filesystem::path& file);

}  // namespace limber::detail
