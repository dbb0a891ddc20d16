// SPDX-License-Identifier: MIT
#pragma once

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "limber/core/pose.hpp"
#include "limber/sensors/camera.hpp"

namespace limber::detail {

/// @brief A sensor.yaml: a YAML mapping whose values are read with checks.
/// Everything that does not fit throws DataError with file and line.
class SensorYaml {
 public:
  explicit SensorYaml(std::filesystem::path path);

  [[nodiscard]] bool has(const std::string& key) const;
  [[nodiscard]] std::string text(const std::string& key) const;
  [[nodiscard]] double number(const std::string& key) const;  ///< finite
  /// Finite numbers of the sequence `key`; with `count`, exactly so many.
  [[nodiscard]] std::vector<double> numbers(const std::string& key,
                                            std::optional<std::size_t> count = std::nullopt) const;
  /// T_BS {rows: 4, cols: 4, data: [16 numbers, row by row]} = T_body_sensor, its rotation made exact.
  [[nodiscard]] Pose body_from_sensor() const;

  [[nodiscard]] double not_negative(const std::string& key) const;
  [[nodiscard]] Eigen::Vector3d not_negative3(const std::string& key) const;

  [[nodiscard]] std::size_t line(const std::string& key) const;  ///< of the value of an existing key
  [[noreturn]] void fail(const std::string& key, const std::string& expected, const std::string& found) const;

 private:
  [[nodiscard]] YAML::Node required(const std::string& key) const;
  [[nodiscard]] double number_of(const YAML::Node& node, const std::string& key) const;
  [[nodiscard]] std::vector<double> numbers_of(const YAML::Node& node, const std::string& key,
                                               std::optional<std::size_t> count) const;
  [[noreturn]] void fail_at(const YAML::Node& node, const std::string& expected,
                            const std::string& found) const;

  std::filesystem::path path_;
  YAML::Node root_;
};

/// camera_model, intrinsics, resolution, distortion_model and distortion_coefficients.
[[nodiscard]] Camera read_camera(const SensorYaml& yaml);

}  // namespace limber::detail
