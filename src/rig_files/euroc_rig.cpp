// SPDX-License-Identifier: MIT
// Folders with one sensor.yaml a camera: EuRoC's, and what cuVSLAM's EuRoC example ships.
#include <fmt/format.h>

#include <array>
#include <utility>

#include "io/numbers.hpp"
#include "rig_files/rig_formats.hpp"

namespace limber::detail {
namespace {

namespace fs = std::filesystem;

std::optional<ImuNoise> noise_of(const SensorYaml& yaml) {
  return missing_imu_noise(yaml) ? std::nullopt : std::optional(read_imu_noise(yaml));
}

/// cuVSLAM calls four fisheye coefficients radial-tangential: the camera model says what they are.
Camera cuvslam_camera(const SensorYaml& yaml) {
  if (yaml.text("camera_model") != "fisheye") {
    return read_camera(yaml);
  }
  const auto intrinsics = yaml.numbers("intrinsics", 4);
  const auto k = yaml.numbers("distortion_coefficients", 4);
  Camera camera{
      intrinsics[0], intrinsics[1], intrinsics[2], intrinsics[3], 0, 0, Equidistant{k[0], k[1], k[2], k[3]}};
  check_pinhole(yaml, "intrinsics", camera);
  read_resolution(yaml, "resolution", camera);
  return camera;
}

}  // namespace

RigFile read_euroc_rig(const fs::path& folder) {
  const SensorYaml yaml0(folder / "cam0" / "sensor.yaml"), yaml1(folder / "cam1" / "sensor.yaml");
  RigFile out;
  out.format = "EuRoC sensor.yaml";
  out.calibration.cam0 = read_camera(yaml0);
  out.calibration.cam1 = read_camera(yaml1);
  out.calibration.readout_time_s = {read_readout_time(yaml0), read_readout_time(yaml1)};
  place_on_imu(out.calibration, yaml0.body_from_sensor(), yaml1.body_from_sensor());
  if (fs::exists(folder / "imu0" / "sensor.yaml")) {
    out.imu_noise = noise_of(SensorYaml(folder / "imu0" / "sensor.yaml"));
  }
  check_rig(out, yaml1.path(), yaml1.line("T_BS"),
            "are the cameras swapped, or are the T_BS inverted (they map camera to body coordinates)?");
  return out;
}

RigFile read_cuvslam_rig(const fs::path& folder) {
  const SensorYaml yaml0(folder / "sensor_cam0.yaml"), yaml1(folder / "sensor_cam1.yaml");
  const SensorYaml imu(folder / "sensor_imu0.yaml");
  RigFile out;
  out.format = "cuVSLAM's sensor_cam0.yaml";
  out.calibration.cam0 = cuvslam_camera(yaml0);
  out.calibration.cam1 = cuvslam_camera(yaml1);
  out.calibration.body = BodyFrame::kCam0;
  out.calibration.theta = rig_from_pose(yaml1.transform("T_Cam0").inverse() * yaml0.transform("T_Cam0"));
  out.notes.emplace_back(
      "sensor_imu0.yaml: its axes are not the IMU's own, so the place of the IMU is left out");
  out.imu_noise = noise_of(imu);
  check_rig(out, yaml1.path(), yaml1.line("T_Cam0"), "are the cameras swapped?");
  return out;
}

}  // namespace limber::detail
