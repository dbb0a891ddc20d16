// SPDX-License-Identifier: MIT
#include "euroc_folder.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>

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
  if (recording.groundtruth.empty()) {
    return;
  }
  const bool biases = recording.groundtruth_has_biases;
  const bool velocity =
      recording.groundtruth_has_velocity || biases;  // the format has no column for biases alone
  std::string header =
      "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []";
  header += velocity ? ",v_RS_R_x [m s^-1],v_RS_R_y [m s^-1],v_RS_R_z [m s^-1]" : "";
  header += biases ? ",b_w_RS_S_x [rad s^-1],b_w_RS_S_y [rad s^-1],b_w_RS_S_z [rad s^-1],b_a_RS_S_x [m s^-2],"
                     "b_a_RS_S_y [m s^-2],b_a_RS_S_z [m s^-2]"
                   : "";
  TableText table("ground truth", ',');
  table.header(header);
  for (const GroundTruthState& state : recording.groundtruth) {
    table.time(state.t_ns);
    table.cells(state.p_world_body);
    table.cells(quaternion_wxyz(state.R_world_body));
    if (velocity) {
      table.cells(state.v_world_body);
    }
    if (biases) {
      table.cells(state.bias_gyro);
      table.cells(state.bias_accel);
    }
    table.end_row();
  }
  write("state_groundtruth_estimate0", "data.csv", table.text());
}

}  // namespace limber::detail
