// SPDX-License-Identifier: MIT
#include "euroc_folder.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>

#include "groundtruth_text.hpp"
#include "io/numbers.hpp"
#include "io/table_text.hpp"
#include "limber/core/errors.hpp"
#include "limber/rig_files/write_rig_files.hpp"
#include "rig_files/euroc_text.hpp"

namespace limber::detail {

namespace fs = std::filesystem;

void EurocFolder::write(const fs::path& subfolder, const fs::path& name, std::string_view content) const {
  const fs::path folder = staged_.path() / subfolder;
  fs::create_directories(folder);
  std::ofstream stream(folder / name, std::ios::binary);
  stream.write(content.data(), static_cast<std::streamsize>(content.size()));
  stream.close();
  if (!stream) {
    throw DataError((mav0_ / subfolder / name).string(), 0, "room to write the file", std::strerror(errno));
  }
}

void EurocFolder::write_cameras(const StereoCalibration& calibration) const {
  write("cam0", "sensor.yaml", euroc_sensor_yaml(calibration, 0));
  write("cam1", "sensor.yaml", euroc_sensor_yaml(calibration, 1));
}

void EurocFolder::write_imu(const Recording& recording) const {
  if (recording.imu.empty()) {
    return;
  }
  TableText table("IMU", ',');
  table.header(
      "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],"
      "a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]");
  for (const ImuSample& sample : recording.imu) {
    table.time(sample.t_ns);
    table.cells(sample.omega_imu);
    table.cells(sample.accel_imu);
    table.end_row();
  }
  write("imu0", "data.csv", table.text());
  std::string yaml = "sensor_type: imu\n" + T_BS_text(Pose{});
  if (recording.imu_noise) {
    const ImuNoise& noise = *recording.imu_noise;
    yaml += fmt::format(
        "gyroscope_noise_density: {}  # [rad/s/sqrt(Hz)]\ngyroscope_random_walk: {}  # [rad/s^2/sqrt(Hz)]\n"
        "accelerometer_noise_density: {}  # [m/s^2/sqrt(Hz)]\naccelerometer_random_walk: {}  # "
        "[m/s^3/sqrt(Hz)]\n",
        noise.gyro_density, noise.gyro_walk, noise.accel_density, noise.accel_walk);
  }
  write("imu0", "sensor.yaml", yaml);
}

void EurocFolder::write_odometry(const Recording& recording) const {
  if (recording.odometry.empty()) {
    return;
  }
  TableText table("odometry", ',');
  table.header(
      "#timestamp [ns],v_x [m s^-1],v_y [m s^-1],v_z [m s^-1],w_x [rad s^-1],w_y [rad s^-1],w_z [rad s^-1]");
  for (const OdometrySample& sample : recording.odometry) {
    table.time(sample.t_ns);
    table.cells(sample.v_body);
    table.cells(sample.omega_body);
    table.end_row();
  }
  write("odometry0", "data.csv", table.text());
  if (const auto& noise = recording.odometry_noise) {
    write("odometry0", "sensor.yaml",
          fmt::format("sigma_v: {}  # [m/s]\nsigma_w: {}  # [rad/s]\n", list_of(noise->sigma_v.data(), 3),
                      list_of(noise->sigma_omega.data(), 3)));
  }
}

void EurocFolder::write_groundtruth(const Recording& recording) const {
  if (!recording.truth.motion.states.empty()) {
    write("state_groundtruth_estimate0", "data.csv", groundtruth_text(recording.truth.motion));
  }
}

}  // namespace limber::detail
