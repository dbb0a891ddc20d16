// SPDX-License-Identifier: MIT
// EuRoC ASL folders: what track logs and recordings with images share, and the images.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <utility>

#include "formats.hpp"
#include "image_checks.hpp"
#include "io/numbers.hpp"
#include "io/text_file.hpp"
#include "io/times_of.hpp"
#include "limber/core/errors.hpp"
#include "limber/core/median.hpp"
#include "limber/datasets/trajectory_files.hpp"
#include "limber/rig_files/rig_file.hpp"
#include "rig_files/check_baseline.hpp"
#include "rig_files/sensor_yaml.hpp"

namespace limber::detail {
namespace {

namespace fs = std::filesystem;

constexpr double kIdentityTolerance = 1e-6;
// Beyond these a column holds something else, or its sensor has failed.
constexpr double kLargestRate = 1e4;   // [rad/s]
constexpr double kLargestForce = 1e5;  // [m/s^2]
constexpr double kLargestSpeed = 1e5;  // [m/s]

// The sensors that limber expects in the body frame itself.
void require_body_frame(const SensorYaml& yaml, const char* sensor) {
  if (!yaml.has("T_BS")) {
    return;
  }
  const Pose T_body_sensor = yaml.body_from_sensor();
  if (!T_body_sensor.R.isIdentity(kIdentityTolerance) || !T_body_sensor.p.isZero(kIdentityTolerance)) {
    yaml.fail("T_BS", fmt::format("the identity as T_BS: the {} must be in the body frame", sensor),
              "another transform");
  }
}

// What the optional sensor.yaml of a folder says; nothing if there is none.
std::optional<SensorYaml> optional_yaml(const fs::path& folder) {
  const fs::path path = folder / "sensor.yaml";
  return fs::exists(path) ? std::optional<SensorYaml>(path) : std::nullopt;
}

// TUM-VI's folders have Kalibr's files beside mav0 instead of a sensor.yaml for each sensor.
fs::path kalibr_folder(const fs::path& mav0) { return fs::absolute(mav0).parent_path() / "dso"; }

bool has_kalibr_files(const fs::path& mav0) {
  return !fs::exists(mav0 / "cam0" / "sensor.yaml") && fs::exists(kalibr_folder(mav0) / "camchain.yaml");
}

void read_kalibr_calibration(const fs::path& mav0, Recording& recording) {
  const fs::path path = kalibr_folder(mav0) / "camchain.yaml";
  const RigFile rig = read_rig_file(path);
  recording.calibration = rig.calibration;
  recording.notes.insert(recording.notes.end(), rig.notes.begin(), rig.notes.end());
  for (const Camera* camera : {&rig.calibration.cam0, &rig.calibration.cam1}) {
    if (camera->width == 0 || camera->height == 0) {
      throw DataError(path.string(), 0, "the resolution of both cameras", "none");
    }
  }
}

void read_calibration(const fs::path& mav0, Recording& recording) {
  if (has_kalibr_files(mav0)) {
    read_kalibr_calibration(mav0, recording);
    return;
  }
  const SensorYaml yaml0(mav0 / "cam0" / "sensor.yaml");
  const SensorYaml yaml1(mav0 / "cam1" / "sensor.yaml");
  StereoCalibration& calibration = recording.calibration;
  calibration.cam0 = read_camera(yaml0);
  calibration.cam1 = read_camera(yaml1);
  calibration.readout_time_s = {read_readout_time(yaml0), read_readout_time(yaml1)};
  const Pose T_imu_cam0 = yaml0.body_from_sensor();  // EuRoC's T_BS
  const Pose T_imu_cam1 = yaml1.body_from_sensor();
  calibration.body = BodyFrame::kImu;
  calibration.T_body_cam0 = T_imu_cam0;
  calibration.theta = rig_from_pose(T_imu_cam1.inverse() * T_imu_cam0);
  const std::string note = check_baseline(
      calibration.theta, mav0 / "cam1" / "sensor.yaml", yaml1.line("T_BS"),
      "are the cameras swapped, or are the T_BS inverted (they map camera to body coordinates)?");
  if (!note.empty()) {
    recording.notes.push_back(note);
  }
}

void take_imu_noise(const fs::path& folder, Recording& recording) {
  const auto yaml = optional_yaml(folder);
  const fs::path kalibr = kalibr_folder(folder.parent_path()) / "imu_config.yaml";
  if (!yaml && fs::exists(kalibr)) {
    recording.imu_noise = read_kalibr_imu(kalibr);
    return;
  }
  if (!yaml) {
    recording.notes.emplace_back("imu0/sensor.yaml is missing: the default IMU noise is assumed");
    return;
  }
  require_body_frame(*yaml, "IMU");
  if (const auto missing = missing_imu_noise(*yaml)) {
    recording.notes.push_back(
        fmt::format("imu0/sensor.yaml does not give {}: the default IMU noise is assumed", *missing));
    return;
  }
  recording.imu_noise = read_imu_noise(*yaml);
}

void read_imu(const fs::path& folder, Recording& recording) {
  TableReader table(folder / "data.csv",
                    {.names = {"timestamp [ns]", "w_x", "w_y", "w_z", "a_x", "a_y", "a_z"}, .counts = {7}});
  while (table.next()) {
    recording.imu.push_back(
        {table.increasing_time(), table.vector3(1, kLargestRate), table.vector3(4, kLargestForce)});
  }
  table.require_a_row("IMU sample");
  constexpr std::int64_t kShortestSample_ns = 20'000;
  require_nanoseconds(times_of(recording.imu), kShortestSample_ns, folder / "data.csv");
  take_imu_noise(folder, recording);
}

void read_odometry(const fs::path& folder, Recording& recording) {
  TableReader table(folder / "data.csv",
                    {.names = {"timestamp [ns]", "v_x", "v_y", "v_z", "w_x", "w_y", "w_z"}, .counts = {7}});
  while (table.next()) {
    recording.odometry.push_back(
        {table.increasing_time(), table.vector3(1, kLargestSpeed), table.vector3(4, kLargestRate)});
  }
  table.require_a_row("odometry sample");
  const auto yaml = optional_yaml(folder);
  if (yaml) {
    require_body_frame(*yaml, "odometry");
  }
  if (!yaml || !yaml->has("sigma_v") || !yaml->has("sigma_w")) {
    recording.notes.emplace_back("odometry0/sensor.yaml does not give sigma_v and sigma_w");
    return;
  }
  recording.odometry_noise = OdometryNoise{yaml->not_negative3("sigma_v"), yaml->not_negative3("sigma_w")};
}

void read_truth(const fs::path& folder, Recording& recording) {
  recording.truth.motion = read_euroc_groundtruth(folder / "data.csv");
  if (const auto yaml = optional_yaml(folder)) {
    require_body_frame(*yaml, "ground truth");
  }
}

void read_landmarks(const fs::path& folder, Recording& recording) {
  TableReader table(folder / "data.csv", {.names = {"track_id", "x [m]", "y [m]", "z [m]"}, .counts = {4}});
  while (table.next()) {
    if (!recording.truth.landmarks.emplace(table.integer(0), table.vector3(1)).second) {
      table.fail("every track_id once", fmt::format("{} again", table.field(0)));
    }
  }
  table.require_a_row("landmark");
}

void read_rig_truth(const fs::path& folder, Recording& recording) {
  recording.truth.rig = read_calibration_truth(folder / "data.csv");
}

// One line of camN/data.csv.
struct ImageLine {
  std::int64_t t_ns;
  fs::path path;
  std::size_t line;
};

std::vector<ImageLine> read_image_list(const fs::path& camera) {
  TableReader table(camera / "data.csv", {.names = {"timestamp [ns]", "filename"}, .counts = {2}});
  std::vector<ImageLine> images;
  while (table.next()) {
    const fs::path name(table.field(1));
    if (name.is_absolute() || std::find(name.begin(), name.end(), "..") != name.end()) {
      table.fail("the name of an image within " + camera.string(), excerpt(table.field(1)));
    }
    const fs::path in_data = camera / "data" / name;
    const fs::path beside = camera / name;
    images.push_back({table.increasing_time(),
                      is_image_file(beside) && !is_image_file(in_data) ? beside : in_data, table.line()});
  }
  table.require_a_row("image");
  return images;
}

DataError no_image(const fs::path& camera, const ImageLine& image) {
  return {(camera / "data.csv").string(), image.line,
          fmt::format("the image {} in {}", image.path.filename().string(), (camera / "data").string()),
          "no such file"};
}

// The sensor.yaml must speak of these images.
void require_resolution(const Recording& recording, std::size_t number) {
  const Camera& camera = number == 0 ? recording.calibration.cam0 : recording.calibration.cam1;
  const auto [file, size] = usual_image(recording, number);
  if (size.width != camera.width || size.height != camera.height) {
    throw DataError(
        file.string(), 0,
        fmt::format("an image of {} x {} pixels, as sensor.yaml says", camera.width, camera.height),
        fmt::format("{} x {}", size.width, size.height));
  }
}

void read_image_pairs(const fs::path& mav0, Recording& recording) {
  const auto left = read_image_list(mav0 / "cam0");
  const auto right = read_image_list(mav0 / "cam1");
  auto l = left.begin();
  auto r = right.begin();
  std::vector<DataError> missing;
  while (l != left.end() && r != right.end()) {
    if (l->t_ns == r->t_ns) {
      if (!is_image_file(l->path)) {
        missing.push_back(no_image(mav0 / "cam0", *l));
      } else if (!is_image_file(r->path)) {
        missing.push_back(no_image(mav0 / "cam1", *r));
      }
      recording.images.push_back({l->t_ns, l++->path, r++->path});
    } else {
      l->t_ns < r->t_ns ? ++l : ++r;
    }
  }
  const std::size_t pairs = recording.images.size();
  if (pairs == 0) {
    throw DataError((mav0 / "cam1" / "data.csv").string(), 0, "timestamps that cam0/data.csv has too",
                    "none");
  }
  if (left.size() != pairs || right.size() != pairs) {
    recording.notes.push_back(fmt::format(
        "{} images of cam0 and {} of cam1 have no partner with the same timestamp and are left out",
        left.size() - pairs, right.size() - pairs));
  }
  require_most_images(recording, missing);
  require_resolution(recording, 0);
  require_resolution(recording, 1);
}

}  // namespace

void require_nanoseconds(const std::vector<std::int64_t>& t_ns, std::int64_t shortest_ns,
                         const fs::path& file) {
  constexpr std::size_t kEnough = 10;
  if (t_ns.size() < kEnough) {
    return;
  }
  std::vector<std::int64_t> steps;
  for (std::size_t k = 1; k < t_ns.size(); ++k) {
    steps.push_back(t_ns[k] - t_ns[k - 1]);
  }
  const std::int64_t step = upper_median(std::move(steps));
  if (step < shortest_ns) {
    throw DataError(file.string(), 0, "timestamps in nanoseconds",
                    fmt::format("steps of {}: are these {}seconds?", step,
                                1000 * step < shortest_ns ? "milli" : "micro"));
  }
}

std::vector<TrueRig> read_calibration_truth(const fs::path& file) {
  TableReader table(
      file, {.names = {"timestamp [ns]", "ax [rad]", "ay [rad]", "az [rad]", "tx [m]", "ty [m]", "tz [m]"},
             .counts = {7}});
  std::vector<TrueRig> rows;
  while (table.next()) {
    TrueRig truth;
    truth.t_ns = table.increasing_time();
    truth.theta.head<3>() = table.vector3(1);
    truth.theta.tail<3>() = table.vector3(4);
    rows.push_back(truth);
  }
  table.require_a_row("sample of the true calibration");
  return rows;
}

Recording read_euroc_common(const fs::path& mav0) {
  Recording recording;
  read_calibration(mav0, recording);
  using Reader = void (*)(const fs::path&, Recording&);
  constexpr std::array<std::pair<const char*, Reader>, 5> kOptional = {
      {{"imu0", read_imu},
       {"odometry0", read_odometry},
       {"state_groundtruth_estimate0", read_truth},
       {"landmarks0", read_landmarks},
       {"calibration_truth0", read_rig_truth}}};
  if (!fs::exists(mav0 / "state_groundtruth_estimate0") && fs::exists(mav0 / "mocap0")) {
    read_truth(mav0 / "mocap0", recording);
  }
  for (const auto& [folder, read] : kOptional) {
    if (fs::exists(mav0 / folder)) {
      read(mav0 / folder, recording);
      note_if_cut_off(mav0 / folder / "data.csv", recording.notes);
    }
  }
  return recording;
}

Recording read_euroc_images(const fs::path& mav0) {
  Recording recording = read_euroc_common(mav0);
  read_image_pairs(mav0, recording);
  require_nanoseconds(times_of(recording.images), kShortestFrame_ns, mav0 / "cam0" / "data.csv");
  note_if_cut_off(mav0 / "cam0" / "data.csv", recording.notes);
  note_if_cut_off(mav0 / "cam1" / "data.csv", recording.notes);
  return recording;
}

}  // namespace limber::detail
