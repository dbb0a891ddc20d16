// SPDX-License-Identifier: MIT
// Writes what OpenVINS' own simulator measures as a track log (docs/formats-recordings.md), by its public
// API, without ROS. benchmarks/peers/README.md says more.
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/VioManagerOptions.h"
#include "sim/Simulator.h"
#include "utils/opencv_yaml_parse.h"
#include "utils/print.h"
#include "utils/quat_ops.h"

namespace {

namespace fs = std::filesystem;

std::int64_t nanoseconds(double t) { return std::llround(1e9 * t); }

template <typename Vector>
void write_numbers(std::ofstream& out, const Vector& numbers) {
  for (Eigen::Index i = 0; i < numbers.size(); ++i) out << ',' << numbers(i);
}

/// A new file in a new folder, with all digits of a double.
std::ofstream new_file(const fs::path& path, const std::string& header) {
  fs::create_directories(path.parent_path());
  std::ofstream out(path);
  if (!out) throw std::runtime_error(path.string() + ": cannot be written");
  out.precision(17);
  out << header << '\n';
  return out;
}

/// Settings of the estimator and of its simulator, with another trajectory and seed.
ov_msckf::VioManagerOptions read_options(const std::string& config, const std::string& trajectory, int seed) {
  ov_core::Printer::setPrintLevel("SILENT");
  const auto parser = std::make_shared<ov_core::YamlParser>(config);
  ov_msckf::VioManagerOptions options;
  options.print_and_load(parser);
  options.print_and_load_simulation(parser);
  if (!parser->successful())
    throw std::runtime_error(config + ": OpenVINS cannot read all of its parameters");
  if (options.state_options.num_cameras != 2 || !options.use_stereo || options.sim_do_perturbation)
    throw std::runtime_error(config + ": expected max_cameras 2, use_stereo true, sim_do_perturbation false");
  options.sim_traj_path = trajectory;
  options.sim_seed_state_init = options.sim_seed_measurements = seed;
  return options;
}

void write_camera(const fs::path& folder, const Eigen::VectorXd& extrinsics, ov_core::CamBase& camera,
                  const std::string& lens) {
  std::ofstream out = new_file(folder / "sensor.yaml", "sensor_type: camera");
  const Eigen::Matrix3d R_body_cam = ov_core::quat_2_Rot(extrinsics.head<4>()).transpose();
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  T.topLeftCorner<3, 3>() = R_body_cam;
  T.topRightCorner<3, 1>() = -R_body_cam * extrinsics.tail<3>();
  out << "T_BS:\n  cols: 4\n  rows: 4\n  data: [";
  for (int i = 0; i < 16; ++i) out << (i > 0 ? ", " : "") << T(i / 4, i % 4);
  const Eigen::VectorXd k = camera.get_value();
  out << "]\nresolution: [" << camera.w() << ", " << camera.h() << "]\ncamera_model: pinhole\n"
      << "intrinsics: [" << k(0) << ", " << k(1) << ", " << k(2) << ", " << k(3) << "]\n"
      << "distortion_model: " << lens << "\ndistortion_coefficients: [" << k(4) << ", " << k(5) << ", "
      << k(6) << ", " << k(7) << "]\n";
}

void write_sensors(const fs::path& mav0, const ov_msckf::VioManagerOptions& options) {
  for (const int i : {0, 1}) {
    const auto& camera = options.camera_intrinsics.at(i);
    const bool is_fisheye = std::dynamic_pointer_cast<ov_core::CamEqui>(camera) != nullptr;
    write_camera(mav0 / ("cam" + std::to_string(i)), options.camera_extrinsics.at(i), *camera,
                 is_fisheye ? "equidistant" : "radial-tangential");
  }
  std::ofstream imu = new_file(mav0 / "imu0/sensor.yaml", "sensor_type: imu");
  imu << "T_BS:\n  cols: 4\n  rows: 4\n  data: [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, "
         "0.0, "
         "0.0, 0.0, 1.0]\n"
      << "rate_hz: " << options.sim_freq_imu << "\ngyroscope_noise_density: " << options.imu_noises.sigma_w
      << "\ngyroscope_random_walk: " << options.imu_noises.sigma_wb
      << "\naccelerometer_noise_density: " << options.imu_noises.sigma_a
      << "\naccelerometer_random_walk: " << options.imu_noises.sigma_ab << '\n';
  const double sigma = options.msckf_options.sigma_pix;
  std::ofstream tracks = new_file(mav0 / "tracks0/sensor.yaml", "# u0, v0, u1, v1");
  tracks << "sigma_px: [" << sigma << ", " << sigma << ", " << sigma << ", " << sigma << "]\n";
}

using Points = std::vector<std::pair<size_t, Eigen::VectorXf>>;

/// One frame as rows of tracks0: points that both cameras see.
void write_frame(std::ofstream& out, std::int64_t t_ns, const Points& left, const Points& right,
                 std::set<size_t>& seen) {
  std::map<size_t, std::array<const Eigen::VectorXf*, 2>> points;
  for (const auto& [id, uv] : left) points[id][0] = &uv;
  for (const auto& [id, uv] : right) points[id][1] = &uv;
  if (points.empty()) out << t_ns << ",,,,,\n";
  for (const auto& [id, cameras] : points) {
    seen.insert(id);
    out << t_ns << ',' << id;
    for (const Eigen::VectorXf* const uv : cameras) {
      if (uv != nullptr)
        write_numbers(out, uv->cast<double>().eval());
      else
        out << ",,";
    }
    out << '\n';
  }
}

/// The truth at these times, as far as the simulator knows it: EuRoC's 17 columns.
void write_truth(const fs::path& mav0, ov_msckf::Simulator& simulator, const std::vector<double>& times) {
  std::ofstream out =
      new_file(mav0 / "state_groundtruth_estimate0/data.csv",
               "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], "
               "q_RS_y [], q_RS_z [], v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1], "
               "b_w_RS_S_x [rad s^-1], b_w_RS_S_y [rad s^-1], b_w_RS_S_z [rad s^-1], "
               "b_a_RS_S_x [m s^-2], b_a_RS_S_y [m s^-2], b_a_RS_S_z [m s^-2]");
  for (const double t : times) {
    Eigen::Matrix<double, 17, 1> state;
    if (!simulator.get_state(t, state)) continue;
    // JPL's quaternion of world to IMU is Hamilton's of IMU to world
    const Eigen::Matrix<double, 1, 16> row =
        (Eigen::Matrix<double, 1, 16>() << state.segment<3>(5).transpose(), state(4),
         state.segment<3>(1).transpose(), state.segment<9>(8).transpose())
            .finished();
    out << nanoseconds(t);
    write_numbers(out, row);
    out << '\n';
  }
}

void write_landmarks(const fs::path& mav0, ov_msckf::Simulator& simulator, const std::set<size_t>& seen) {
  std::ofstream out = new_file(mav0 / "landmarks0/data.csv", "#track_id,x [m],y [m],z [m]");
  const auto map = simulator.get_map();
  for (const size_t id : seen) {
    out << id;
    write_numbers(out, map.at(id));
    out << '\n';
  }
}

/// Everything that the simulator measures, in the order of time.
void write_recording(ov_msckf::VioManagerOptions& options, const fs::path& folder) {
  const fs::path mav0 = folder / "mav0";
  ov_msckf::Simulator simulator(options);
  write_sensors(mav0, options);
  std::ofstream imu = new_file(mav0 / "imu0/data.csv",
                               "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
                               "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]");
  std::ofstream tracks =
      new_file(mav0 / "tracks0/data.csv", "#timestamp [ns],track_id,u0 [px],v0 [px],u1 [px],v1 [px]");
  std::vector<double> times;
  std::set<size_t> seen;
  while (simulator.ok()) {
    double t = 0.0;
    Eigen::Vector3d omega, force;
    if (simulator.get_next_imu(t, omega, force)) {
      imu << nanoseconds(t);
      write_numbers(imu, omega);
      write_numbers(imu, force);
      imu << '\n';
    }
    std::vector<int> cameras;
    std::vector<Points> points;
    if (simulator.get_next_cam(t, cameras, points)) {
      write_frame(tracks, nanoseconds(t), points.at(0), points.at(1), seen);
      times.push_back(t);
    }
  }
  write_truth(mav0, simulator, times);
  write_landmarks(mav0, simulator, seen);
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (words.size() != 4) {
    std::cerr << "openvins_simulation ESTIMATOR_CONFIG TRAJECTORY SEED NEW_FOLDER\n";
    return 2;
  }
  try {
    if (fs::exists(words[3])) throw std::runtime_error(words[3] + " is there: nothing is ever replaced");
    if (!fs::is_regular_file(words[1])) throw std::runtime_error(words[1] + ": no trajectory of this name");
    ov_msckf::VioManagerOptions options = read_options(words[0], words[1], std::stoi(words[2]));
    write_recording(options, words[3]);
  } catch (const std::exception& error) {
    std::cerr << "openvins_simulation: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
