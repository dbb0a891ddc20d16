// SPDX-License-Identifier: MIT
// Feeds an EuRoC folder to OpenVINS by its public API, without ROS: every stereo pair, in the order of time.
// Writes the pose of the IMU after each pair, before the next is read (causal), and what that took.
// benchmarks/peers/README.md says more.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <exception>
#include <fstream>
#include <iostream>
#include <map>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/VioManager.h"
#include "core/VioManagerOptions.h"
#include "state/State.h"
#include "track/TrackKLT.h"
#include "utils/opencv_yaml_parse.h"
#include "utils/print.h"
#include "utils/sensor_data.h"

namespace {

/// CPU time of all threads of this process [s].
double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Lines of a CSV file that are neither empty nor comments, with their fields.
std::vector<std::vector<std::string>> read_csv(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + ": cannot be read");
  std::vector<std::vector<std::string>> rows;
  for (std::string line; std::getline(file, line);) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty() || line.front() == '#') continue;
    std::stringstream fields(line);
    rows.emplace_back();
    for (std::string field; std::getline(fields, field, ',');) rows.back().push_back(field);
  }
  return rows;
}

double seconds(std::int64_t t_ns) { return 1e-9 * static_cast<double>(t_ns); }

std::vector<ov_core::ImuData> read_imu(const std::string& recording) {
  const std::string path = recording + "/mav0/imu0/data.csv";
  std::vector<ov_core::ImuData> samples;
  for (const auto& row : read_csv(path)) {
    if (row.size() < 7)
      throw std::runtime_error(path + ": expected t, three angular rates, three specific forces");
    ov_core::ImuData sample;
    sample.timestamp = seconds(std::stoll(row[0]));
    sample.wm << std::stod(row[1]), std::stod(row[2]), std::stod(row[3]);
    sample.am << std::stod(row[4]), std::stod(row[5]), std::stod(row[6]);
    samples.push_back(sample);
  }
  return samples;
}

struct ImagePair {
  std::int64_t t_ns;
  std::string left, right;
};

std::map<std::int64_t, std::string> read_camera(const std::string& folder) {
  std::map<std::int64_t, std::string> images;
  for (const auto& row : read_csv(folder + "/data.csv")) {
    if (row.size() < 2) throw std::runtime_error(folder + "/data.csv: expected t, file");
    images[std::stoll(row[0])] = folder + "/data/" + row[1].substr(row[1].find_first_not_of(' '));
  }
  return images;
}

/// Pairs of equal stamps.
std::vector<ImagePair> read_pairs(const std::string& recording) {
  const auto left = read_camera(recording + "/mav0/cam0"), right = read_camera(recording + "/mav0/cam1");
  std::vector<ImagePair> pairs;
  for (const auto& [t_ns, file] : left)
    if (const auto other = right.find(t_ns); other != right.end())
      pairs.push_back({t_ns, file, other->second});
  if (pairs.empty()) throw std::runtime_error(recording + ": cam0 and cam1 have no stamps in common");
  return pairs;
}

ov_core::CameraData load(const ImagePair& pair) {
  ov_core::CameraData data;
  data.timestamp = seconds(pair.t_ns);
  for (const int camera : {0, 1}) {
    const std::string& file = camera == 0 ? pair.left : pair.right;
    data.sensor_ids.push_back(camera);
    data.images.push_back(cv::imread(file, cv::IMREAD_GRAYSCALE));
    if (data.images.back().empty()) throw std::runtime_error(file + ": not an image");
    data.masks.push_back(cv::Mat::zeros(data.images.back().size(), CV_8UC1));
  }
  return data;
}

/// t [s], quaternion (x y z w, as OpenVINS has it: of the rotation from world to IMU), p, v, gyro bias,
/// accelerometer bias.
Eigen::Matrix<double, 17, 1> read_start(const std::string& path) {
  std::ifstream file(path);
  Eigen::Matrix<double, 17, 1> start;
  for (int i = 0; i < 17; ++i)
    if (!(file >> start(i))) throw std::runtime_error(path + ": expected 17 numbers");
  return start;
}

struct Totals {
  std::size_t frames = 0, poses = 0, points_left = 0, points_right = 0;
  double decode_s = 0, estimate_s = 0;
};

void write_pose(std::ofstream& out, std::int64_t t_ns, const ov_type::IMU& imu, Totals& totals) {
  const Eigen::Vector4d q =
      imu.quat();  // x y z w by JPL of world to IMU: the Hamilton quaternion of IMU to world
  const Eigen::Vector3d p = imu.pos();
  if (!q.allFinite() || !p.allFinite()) return;
  char line[256];
  std::snprintf(line, sizeof line, "%lld.%09lld %.9f %.9f %.9f %.9f %.9f %.9f %.9f\n",
                static_cast<long long>(t_ns / 1000000000), static_cast<long long>(t_ns % 1000000000), p(0),
                p(1), p(2), q(0), q(1), q(2), q(3));
  out << line;
  ++totals.poses;
}

ov_msckf::VioManagerOptions read_options(const std::string& config) {
  ov_core::Printer::setPrintLevel("SILENT");
  const auto parser = std::make_shared<ov_core::YamlParser>(config);
  ov_msckf::VioManagerOptions options;
  options.print_and_load(parser);
  options.use_multi_threading_subs = false;
  if (!parser->successful())
    throw std::runtime_error(config + ": OpenVINS cannot read all of its parameters");
  return options;
}

/// The whole estimator. A pair is processed when the IMU has passed it, as in OpenVINS' own reader.
Totals navigate(const std::string& config, const std::string& recording, const std::string& out_path,
                const std::string& start) {
  ov_msckf::VioManagerOptions options = read_options(config);
  ov_msckf::VioManager system(options);
  const auto imu = read_imu(recording);
  if (!start.empty()) system.initialize_with_gt(read_start(start));
  std::ofstream out(out_path);
  if (!out) throw std::runtime_error(out_path + ": cannot be written");
  Totals totals;
  std::size_t next = 0;
  for (const ImagePair& pair : read_pairs(recording)) {
    double begin = cpu_seconds();
    const ov_core::CameraData data = load(pair);
    totals.decode_s += cpu_seconds() - begin;
    begin = cpu_seconds();
    const double until = data.timestamp + system.get_state()->_calib_dt_CAMtoIMU->value()(0);
    while (next < imu.size()) {
      system.feed_measurement_imu(imu[next]);
      if (imu[next++].timestamp > until) break;
    }
    system.feed_measurement_camera(data);
    totals.estimate_s += cpu_seconds() - begin;
    ++totals.frames;
    if (std::abs(system.get_state()->_timestamp - data.timestamp) < 1e-6)
      write_pose(out, pair.t_ns, *system.get_state()->_imu, totals);
  }
  return totals;
}

/// TrackKLT alone, with `points` a camera.
Totals track(const std::string& config, const std::string& recording, int points) {
  ov_msckf::VioManagerOptions options = read_options(config);
  cv::setNumThreads(options.num_opencv_threads);
  ov_core::TrackKLT tracker(options.camera_intrinsics, points, 0, true, options.histogram_method,
                            options.fast_threshold, options.grid_x, options.grid_y, options.min_px_dist);
  Totals totals;
  for (const ImagePair& pair : read_pairs(recording)) {
    double begin = cpu_seconds();
    const ov_core::CameraData data = load(pair);
    totals.decode_s += cpu_seconds() - begin;
    begin = cpu_seconds();
    tracker.feed_new_camera(data);
    totals.estimate_s += cpu_seconds() - begin;
    ++totals.frames;
    auto seen = tracker.get_last_obs();
    totals.points_left += seen[0].size();
    totals.points_right += seen[1].size();
  }
  return totals;
}

void print(const Totals& totals) {
  const double frames = static_cast<double>(totals.frames);
  std::printf(
      "{\"frames\": %zu, \"poses\": %zu, \"decode_ms\": %.4f, \"estimate_ms\": %.4f, \"points_left\": %.2f, "
      "\"points_right\": %.2f}\n",
      totals.frames, totals.poses, 1e3 * totals.decode_s / frames, 1e3 * totals.estimate_s / frames,
      static_cast<double>(totals.points_left) / frames, static_cast<double>(totals.points_right) / frames);
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  try {
    if (words.size() >= 4 && words.size() <= 5 && words[0] == "run")
      print(navigate(words[1], words[2], words[3], words.size() == 5 ? words[4] : ""));
    else if (words.size() == 4 && words[0] == "track")
      print(track(words[1], words[2], std::stoi(words[3])));
    else {
      std::cerr << "openvins_runner run ESTIMATOR_CONFIG RECORDING TRAJECTORY [START]\n"
                   "openvins_runner track ESTIMATOR_CONFIG RECORDING POINTS\n";
      return 2;
    }
  } catch (const std::exception& error) {
    std::cerr << "openvins_runner: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
