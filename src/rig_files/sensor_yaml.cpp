// SPDX-License-Identifier: MIT
#include "rig_files/sensor_yaml.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "io/numbers.hpp"
#include "io/text_file.hpp"
#include "io/yaml_text.hpp"
#include "io/yaml_words.hpp"
#include "limber/core/errors.hpp"
#include "rig_files/opencv_lens.hpp"
#include "rig_files/rig_formats.hpp"

namespace limber::detail {
namespace {

constexpr double kLargestResolution = 100'000.0;
constexpr double kLargestNoise = 1e6;  // whatever its unit
constexpr double kBottomRowTolerance = 1e-6;
constexpr std::array<std::pair<const char*, double ImuNoise::*>, 4> kImuNoise = {
    {{"gyroscope_noise_density", &ImuNoise::gyro_density},
     {"gyroscope_random_walk", &ImuNoise::gyro_walk},
     {"accelerometer_noise_density", &ImuNoise::accel_density},
     {"accelerometer_random_walk", &ImuNoise::accel_walk}}};

// EuRoC files start with OpenCV's "%YAML:1.0", which is no YAML directive.
void blank_out_opencv_directive(std::string& text) {
  if (text.starts_with("%YAML:")) {
    text.replace(0, std::min(text.find('\n'), text.size()), "");
  }
}

// Of a section; a whole file has none.
std::size_t root_section_line(const YAML::Node& root) {
  const std::size_t line = line_of(root.Mark());
  return root.Mark().column > 0 ? line : 0;
}

Distortion read_distortion(const SensorYaml& yaml) {
  const std::string model = yaml.text("distortion_model");
  if (model == "none") {
    if (yaml.has("distortion_coefficients")) {
      static_cast<void>(yaml.numbers("distortion_coefficients", 0));
    }
    return NoDistortion{};
  }
  if (model == "radial-tangential" || model == "radtan") {
    const auto k = yaml.numbers("distortion_coefficients");
    if (k.size() != 4 && k.size() != 5 && k.size() != 8) {
      yaml.fail("distortion_coefficients", "distortion_coefficients as a list of 4, 5 or 8 numbers",
                fmt::format("{} numbers", k.size()));
    }
    return opencv_lens(k);
  }
  if (model == "equidistant") {
    const auto k = yaml.numbers("distortion_coefficients", 4);
    return Equidistant{k[0], k[1], k[2], k[3]};
  }
  yaml.fail("distortion_model", "distortion_model none, radial-tangential, radtan or equidistant",
            excerpt(model));
}

Omni omni_lens(double xi, const Distortion& distortion, const SensorYaml& yaml) {
  if (std::holds_alternative<NoDistortion>(distortion)) {
    return {.xi = xi};
  }
  if (const auto* d = std::get_if<RadialTangential>(&distortion)) {
    return {xi, d->k1, d->k2, d->p1, d->p2};
  }
  yaml.fail("distortion_model",
            "distortion_model none, or radial-tangential with four coefficients, of an omni camera",
            "another");
}

}  // namespace

SensorYaml::SensorYaml(std::filesystem::path path) : path_(std::move(path)) {
  std::string text = load_text(path_);
  blank_out_opencv_directive(text);
  root_ = parse_yaml(text, path_.string());
  if (!root_.IsMap()) {
    throw DataError(path_.string(), 0, "a YAML mapping (key: value)", in_words(root_));
  }
}

bool SensorYaml::has(const std::string& key) const { return root_[key].IsDefined(); }

YAML::Node SensorYaml::required(const std::string& key) const {
  if (!has(key)) {
    throw DataError(path_.string(), root_section_line(root_), "the key " + key, "no such key");
  }
  return root_[key];
}

std::string SensorYaml::text(const std::string& key) const {
  const YAML::Node node = required(key);
  if (!node.IsScalar()) {
    fail_at(node, key + " as text", in_words(node));
  }
  return node.Scalar();
}

double SensorYaml::number(const std::string& key) const { return number_of(required(key), key); }

std::vector<double> SensorYaml::numbers(const std::string& key, std::optional<std::size_t> count) const {
  return numbers_of(required(key), key, count);
}

double SensorYaml::number_of(const YAML::Node& node, const std::string& key) const {
  const auto value = node.IsScalar() ? parse_number(node.Scalar()) : std::nullopt;
  if (!value || !std::isfinite(*value)) {
    fail_at(node, "a finite number in " + key, in_words(node));
  }
  return *value;
}

std::vector<double> SensorYaml::numbers_of(const YAML::Node& node, const std::string& key,
                                           std::optional<std::size_t> count) const {
  if (!node.IsSequence() || (count && node.size() != *count)) {
    fail_at(node,
            count ? fmt::format("{} as a list of {} numbers", key, *count) : key + " as a list of numbers",
            in_words(node));
  }
  std::vector<double> values;
  for (const YAML::Node& entry : node) {
    values.push_back(number_of(entry, key));
  }
  return values;
}

SensorYaml SensorYaml::section(const std::string& key) const {
  const YAML::Node node = required(key);
  if (!node.IsMap()) {
    fail_at(node, key + " as a mapping", in_words(node));
  }
  return {path_, node};
}

std::vector<SensorYaml> SensorYaml::sections(const std::string& key, std::size_t count) const {
  const YAML::Node node = required(key);
  if (!node.IsSequence() || node.size() != count) {
    fail_at(node, fmt::format("{} as a list of {}", key, count), in_words(node));
  }
  std::vector<SensorYaml> out;
  for (const YAML::Node& entry : node) {
    if (!entry.IsMap()) {
      fail_at(entry, "a mapping in " + key, in_words(entry));
    }
    out.push_back(SensorYaml(path_, entry));
  }
  return out;
}

std::vector<double> SensorYaml::entries(const std::string& key) const {
  const YAML::Node node = required(key);
  const YAML::Node data = node.IsMap() ? node["data"] : node;
  if (!data.IsDefined() || !data.IsSequence()) {
    fail_at(node, key + " as rows: cols: data: [numbers] or as a list", in_words(node));
  }
  std::vector<double> out;
  for (const YAML::Node& entry : data) {
    if (entry.IsSequence()) {
      const auto row = numbers_of(entry, key, std::nullopt);
      out.insert(out.end(), row.begin(), row.end());
    } else {
      out.push_back(number_of(entry, key));
    }
  }
  return out;
}

Eigen::MatrixXd SensorYaml::matrix(const std::string& key, Eigen::Index rows, Eigen::Index cols) const {
  const YAML::Node node = required(key);
  const auto size = static_cast<std::size_t>(rows * cols);
  const std::vector<double> data = entries(key);
  for (const auto& [name, expected] : {std::pair{"rows", rows}, std::pair{"cols", cols}}) {
    if (node.IsMap() && node[name].IsDefined() &&
        number_of(node[name], key + " " + name) != static_cast<double>(expected)) {
      fail_at(node[name], fmt::format("{} {} in {}", expected, name, key), in_words(node[name]));
    }
  }
  if (data.size() != size) {
    fail_at(node, fmt::format("{} as {} x {} numbers", key, rows, cols),
            fmt::format("{} numbers", data.size()));
  }
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  return Eigen::Map<const RowMajor>(data.data(), rows, cols);
}

Pose SensorYaml::rigid(const YAML::Node& node, const std::string& key, const Eigen::Matrix4d& T) const {
  const auto R = checked_rotation(T.topLeftCorner<3, 3>());
  if (!R) {
    const Eigen::Matrix3d block = T.topLeftCorner<3, 3>();
    const double error = (block.transpose() * block - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
    fail_at(node, key + " with a rotation in its upper left 3x3 block (R^T R = I, det R = 1)",
            fmt::format("R^T R off by {:.2g}, det R = {:.4g}", error, block.determinant()));
  }
  if ((T.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() > kBottomRowTolerance) {
    fail_at(node, "0 0 0 1 as the last row of " + key,
            fmt::format("{} {} {} {}", T(3, 0), T(3, 1), T(3, 2), T(3, 3)));
  }
  return {*R, T.topRightCorner<3, 1>()};
}

Pose SensorYaml::transform(const std::string& key) const {
  return rigid(required(key), key, matrix(key, 4, 4));
}

Pose SensorYaml::body_from_sensor() const {
  const YAML::Node node = required("T_BS");
  if (!node.IsMap() || !node["data"].IsDefined()) {
    fail_at(node, "T_BS with rows: 4, cols: 4 and data: [16 numbers]", in_words(node));
  }
  static_cast<void>(numbers_of(node["data"], "T_BS data", 16));
  return transform("T_BS");
}

double SensorYaml::not_negative(const std::string& key) const {
  const double value = number(key);
  if (value < 0.0 || value > kLargestNoise) {
    fail(key, fmt::format("{} of zero or more, at most {}", key, kLargestNoise), fmt::format("{}", value));
  }
  return value;
}

Eigen::Vector3d SensorYaml::not_negative3(const std::string& key) const {
  const auto values = numbers(key, 3);
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  if (*least < 0.0 || *most > kLargestNoise) {
    fail(key, fmt::format("{} of zero or more, at most {}", key, kLargestNoise),
         fmt::format("[{}, {}, {}]", values[0], values[1], values[2]));
  }
  return {values[0], values[1], values[2]};
}

std::size_t SensorYaml::line(const std::string& key) const { return line_of(required(key).Mark()); }

void SensorYaml::fail(const std::string& key, const std::string& expected, const std::string& found) const {
  fail_at(required(key), expected, found);
}

void SensorYaml::fail_at(const YAML::Node& node, const std::string& expected,
                         const std::string& found) const {
  throw DataError(path_.string(), line_of(node.Mark()), expected, found);
}

void check_pinhole(const SensorYaml& yaml, const std::string& key, const Camera& camera) {
  if (!is_focal_length(camera.fu) || !is_focal_length(camera.fv)) {
    yaml.fail(key, kFocalLengthsInWords, fmt::format("{} and {}", camera.fu, camera.fv));
  }
}

void read_resolution(const SensorYaml& yaml, const std::string& key, Camera& camera) {
  const auto resolution = yaml.numbers(key, 2);
  for (const double side : resolution) {
    if (side < 1.0 || side > kLargestResolution || side != std::floor(side)) {
      yaml.fail(key, key + " as positive whole numbers [width, height]",
                fmt::format("[{}, {}]", resolution[0], resolution[1]));
    }
  }
  camera.width = static_cast<int>(resolution[0]);
  camera.height = static_cast<int>(resolution[1]);
}

Camera read_camera(const SensorYaml& yaml) {
  const std::string model = yaml.text("camera_model");
  const bool omni = model == "omni";
  if (model != "pinhole" && !omni) {
    yaml.fail("camera_model", "camera_model pinhole or omni", excerpt(model));
  }
  const auto intrinsics = yaml.numbers("intrinsics", omni ? 5 : 4);  // of omni, xi stands first
  const double* f = &intrinsics[omni ? 1 : 0];
  Camera camera{f[0], f[1], f[2], f[3], 0, 0, NoDistortion{}};
  check_pinhole(yaml, "intrinsics", camera);
  read_resolution(yaml, "resolution", camera);
  const Distortion distortion = read_distortion(yaml);
  if (omni) {
    return omni_camera(camera, omni_lens(intrinsics[0], distortion, yaml), yaml, "intrinsics");
  }
  camera.distortion = distortion;
  return camera;
}

double checked_readout(const SensorYaml& yaml, const std::string& key, double unit) {
  const double readout = unit * yaml.number(key);
  if (std::abs(readout) > kLongestReadout) {
    yaml.fail(key, fmt::format("{} of at most {} s from the first row to the last", key, kLongestReadout),
              fmt::format("{} s", readout));
  }
  return readout;
}

std::optional<std::string> missing_imu_noise(const SensorYaml& yaml) {
  for (const auto& [key, value] : kImuNoise) {
    if (!yaml.has(key)) {
      return key;
    }
  }
  return std::nullopt;
}

ImuNoise read_imu_noise(const SensorYaml& yaml) {
  ImuNoise noise;
  for (const auto& [key, value] : kImuNoise) {
    noise.*value = yaml.not_negative(key);
  }
  return noise;
}

double read_readout_time(const SensorYaml& yaml) {
  return yaml.has("readout_time") ? checked_readout(yaml, "readout_time", 1.0) : 0.0;
}

}  // namespace limber::detail
