// SPDX-License-Identifier: MIT
#include "sensor_yaml.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "io/numbers.hpp"
#include "io/text_file.hpp"
#include "io/yaml_text.hpp"
#include "io/yaml_words.hpp"
#include "limber/core/errors.hpp"

namespace limber::detail {
namespace {

constexpr double kLargestResolution = 100'000.0;
constexpr double kLargestNoise = 1e6;  // whatever its unit
constexpr double kBottomRowTolerance = 1e-6;

// EuRoC files start with OpenCV's "%YAML:1.0", which is no YAML directive.
void blank_out_opencv_directive(std::string& text) {
  if (text.starts_with("%YAML:")) {
    text.replace(0, std::min(text.find('\n'), text.size()), "");
  }
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
    const auto k = yaml.numbers("distortion_coefficients", 4);
    return RadialTangential{k[0], k[1], k[2], k[3]};
  }
  if (model == "equidistant") {
    const auto k = yaml.numbers("distortion_coefficients", 4);
    return Equidistant{k[0], k[1], k[2], k[3]};
  }
  yaml.fail("distortion_model", "distortion_model none, radial-tangential, radtan or equidistant",
            excerpt(model));
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
    throw DataError(path_.string(), 0, "the key " + key, "no such key");
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

Pose SensorYaml::body_from_sensor() const {
  const YAML::Node node = required("T_BS");
  if (!node.IsMap() || !node["data"].IsDefined()) {
    fail_at(node, "T_BS with rows: 4, cols: 4 and data: [16 numbers]", in_words(node));
  }
  for (const char* const size : {"rows", "cols"}) {
    if (node[size].IsDefined() && number_of(node[size], std::string("T_BS ") + size) != 4.0) {
      fail_at(node[size], fmt::format("4 {} in T_BS", size), in_words(node[size]));
    }
  }
  const auto data = numbers_of(node["data"], "T_BS data", 16);
  const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> T(data.data());
  const auto R = checked_rotation(T.topLeftCorner<3, 3>());
  if (!R) {
    const Eigen::Matrix3d block = T.topLeftCorner<3, 3>();
    const double error = (block.transpose() * block - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
    fail_at(node, "T_BS with a rotation in its upper left 3x3 block (R^T R = I, det R = 1)",
            fmt::format("R^T R off by {:.2g}, det R = {:.4g}", error, block.determinant()));
  }
  if ((T.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() > kBottomRowTolerance) {
    fail_at(node, "0 0 0 1 as the last row of T_BS",
            fmt::format("{} {} {} {}", T(3, 0), T(3, 1), T(3, 2), T(3, 3)));
  }
  return {*R, T.topRightCorner<3, 1>()};
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

Camera read_camera(const SensorYaml& yaml) {
  if (const std::string model = yaml.text("camera_model"); model != "pinhole") {
    yaml.fail("camera_model", "camera_model pinhole", excerpt(model));
  }
  Camera camera;
  const auto intrinsics = yaml.numbers("intrinsics", 4);
  if (!is_focal_length(intrinsics[0]) || !is_focal_length(intrinsics[1])) {
    yaml.fail("intrinsics", kFocalLengthsInWords, fmt::format("{} and {}", intrinsics[0], intrinsics[1]));
  }
  camera.fu = intrinsics[0];
  camera.fv = intrinsics[1];
  camera.cu = intrinsics[2];
  camera.cv = intrinsics[3];
  const auto resolution = yaml.numbers("resolution", 2);
  for (const double side : resolution) {
    if (side < 1.0 || side > kLargestResolution || side != std::floor(side)) {
      yaml.fail("resolution", "resolution as positive whole numbers [width, height]",
                fmt::format("[{}, {}]", resolution[0], resolution[1]));
    }
  }
  camera.width = static_cast<int>(resolution[0]);
  camera.height = static_cast<int>(resolution[1]);
  camera.distortion = read_distortion(yaml);
  return camera;
}

}  // namespace limber::detail
