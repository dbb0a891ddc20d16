// SPDX-License-Identifier: MIT
// Feeds an EuRoC folder or a track log to OpenVINS by its public API, without ROS: every stereo pair, in the
// order of time. Writes the pose of the IMU after each pair, before the next is read (causal), and what that
// took. benchmarks/peers/README.md says more.
#include <algorithm>
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
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/VioManager.h"
#include "core/VioManagerOptions.h"
#include "read_recording.hpp"
#include "state/State.h"
#include "state/StateHelper.h"
#include "track/TrackKLT.h"
#include "utils/opencv_yaml_parse.h"
#include "utils/print.h"
#include "utils/sensor_data.h"

namespace {

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
    data.sensor_ids.push_back(camera);
    data.images.push_back(read_image(camera == 0 ? pair.left : pair.right));
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

/// The matched points of a frame, as OpenVINS' simulator hands them over.
struct TrackedFrame {
  std::int64_t t_ns = 0;
  std::vector<std::vector<std::pair<std::size_t, Eigen::VectorXf>>> points{2};
};

std::string tracks_of(const std::string& recording) { return recording + "/mav0/tracks0/data.csv"; }

std::vector<TrackedFrame> read_tracks(const std::string& recording) {
  std::vector<TrackedFrame> frames;
  for (auto& row : read_csv(tracks_of(recording))) {
    row.resize(6);  // the last fields of a point that the right camera does not see are empty
    if (frames.empty() || frames.back().t_ns != std::stoll(row[0])) {
      frames.emplace_back();
      frames.back().t_ns = std::stoll(row[0]);
    }
    for (const std::size_t camera : {0, 1}) {
      const std::string &u = row[2 + 2 * camera], &v = row[3 + 2 * camera];
      if (u.empty() || v.empty()) continue;
      frames.back().points[camera].emplace_back(std::stoull(row[1]),
                                                Eigen::Vector2f(std::stof(u), std::stof(v)));
    }
  }
  return frames;
}

struct Totals {
  std::size_t frames = 0, poses = 0, points_left = 0, points_right = 0;
  double decode_s = 0, estimate_s = 0;
};

/// The columns of limber's trajectory.csv.
std::string header() {
  std::string text =
      "t_ns,px [m],py [m],pz [m],qw [-],qx [-],qy [-],qz [-],vx [m/s],vy [m/s],vz [m/s],bgx [rad/s],"
      "bgy [rad/s],bgz [rad/s],bax [m/s^2],bay [m/s^2],baz [m/s^2]";
  const std::array<std::string, 6> errors{"px", "py", "pz", "rx", "ry", "rz"};
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = i; j < 6; ++j)
      text += ",P_" + errors[i] + "_" + errors[j] + (j < 3 ? " [m^2]" : i < 3 ? " [m rad]" : " [rad^2]");
  return text;
}

/// Position and attitude, and their covariance, in limber's order: OpenVINS' has the attitude first, both
/// local to the IMU.
void write_row(std::ofstream& out, std::int64_t t_ns, const std::shared_ptr<ov_msckf::State>& state,
               Totals& totals) {
  const auto imu = state->_imu;
  const Eigen::Vector4d q =
      imu->quat();  // x y z w by JPL of world to IMU: the Hamilton quaternion of IMU to world
  const Eigen::Matrix<double, 6, 6> P = ov_msckf::StateHelper::get_marginal_covariance(state, {imu->pose()});
  if (!q.allFinite() || !imu->pos().allFinite() || !P.allFinite()) return;
  out << t_ns;
  for (int i = 0; i < 3; ++i) out << ',' << imu->pos()(i);
  for (const int i : {3, 0, 1, 2}) out << ',' << q(i);
  for (int i = 0; i < 3; ++i) out << ',' << imu->vel()(i);
  for (int i = 0; i < 3; ++i) out << ',' << imu->bias_g()(i);
  for (int i = 0; i < 3; ++i) out << ',' << imu->bias_a()(i);
  const std::array<int, 6> order{3, 4, 5, 0, 1, 2};
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = i; j < 6; ++j) out << ',' << P(order[i], order[j]);
  out << '\n';
  ++totals.poses;
}

std::ofstream new_trajectory(const std::string& path) {
  std::ofstream out(path);
  if (!out) throw std::runtime_error(path + ": cannot be written");
  out.precision(12);
  out << header() << '\n';
  return out;
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

/// Steps through the IMU's samples beside the frames: a frame is processed when the IMU has passed it, as in
/// OpenVINS' own reader.
class Estimator {
 public:
  Estimator(ov_msckf::VioManagerOptions options, const std::string& recording, const std::string& out_path,
            const std::string& start)
      : system_(options), imu_(read_imu(recording)), out_(new_trajectory(out_path)) {
    if (!start.empty()) system_.initialize_with_gt(read_start(start));
  }

  /// Feeds the IMU up to the frame, then what `feed` feeds, and writes the pose.
  template <typename Feed>
  void step(std::int64_t t_ns, Totals& totals, Feed&& feed) {
    const double begin = cpu_seconds(), t = seconds(t_ns);
    const double until = t + system_.get_state()->_calib_dt_CAMtoIMU->value()(0);
    while (next_ < imu_.size()) {
      system_.feed_measurement_imu(imu_[next_]);
      if (imu_[next_++].timestamp > until) break;
    }
    feed(system_);
    totals.estimate_s += cpu_seconds() - begin;
    ++totals.frames;
    if (std::abs(system_.get_state()->_timestamp - t) < 1e-6)
      write_row(out_, t_ns, system_.get_state(), totals);
  }

 private:
  ov_msckf::VioManager system_;
  std::vector<ov_core::ImuData> imu_;
  std::ofstream out_;
  std::size_t next_ = 0;
};

Totals navigate_images(Estimator& estimator, const std::string& recording) {
  Totals totals;
  for (const ImagePair& pair : read_pairs(recording)) {
    const double begin = cpu_seconds();
    const ov_core::CameraData data = load(pair);
    totals.decode_s += cpu_seconds() - begin;
    estimator.step(pair.t_ns, totals,
                   [&](ov_msckf::VioManager& system) { system.feed_measurement_camera(data); });
  }
  return totals;
}

Totals navigate_tracks(Estimator& estimator, const std::string& recording) {
  Totals totals;
  for (const TrackedFrame& frame : read_tracks(recording)) {
    estimator.step(frame.t_ns, totals, [&](ov_msckf::VioManager& system) {
      system.feed_measurement_simulation(seconds(frame.t_ns), {0, 1}, frame.points);
    });
    totals.points_left += frame.points[0].size();
    totals.points_right += frame.points[1].size();
  }
  return totals;
}

/// The whole estimator.
Totals navigate(const std::string& config, const std::string& recording, const std::string& out_path,
                const std::string& start) {
  const bool has_tracks = std::filesystem::exists(tracks_of(recording));
  if (has_tracks && start.empty())
    throw std::runtime_error(recording + ": OpenVINS takes matched points only after a given START");
  Estimator estimator(read_options(config), recording, out_path, start);
  return has_tracks ? navigate_tracks(estimator, recording) : navigate_images(estimator, recording);
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
