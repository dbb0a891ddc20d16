// SPDX-License-Identifier: MIT
#pragma once

#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "limber/core/pose.hpp"
#include "limber/sensors/calibration.hpp"
#include "limber/sensors/camera.hpp"

namespace limber::detail {

/// @brief A sensor.yaml: a YAML mapping whose values are read with checks.
/// Everything that does not fit throws DataError with file and line.
class SensorYaml {
 public:
  explicit SensorYaml(std::filesystem::path path);

  /// The mapping below `key`.
  [[nodiscard]] SensorYaml section(const std::string& key) const;
  /// The mappings of the sequence `key`; exactly `count`.
  [[nodiscard]] std::vector<SensorYaml> sections(const std::string& key, std::size_t count) const;

  [[nodiscard]] bool has(const std::string& key) const;
  [[nodiscard]] std::string text(const std::string& key) const;
  [[nodiscard]] double number(const std::string& key) const;  ///< finite
  /// Finite numbers of the sequence `key`; with `count`, exactly so many.
  [[nodiscard]] std::vector<double> numbers(const std::string& key,
                                            std::optional<std::size_t> count = std::nullopt) const;
  /// T_BS {rows: 4, cols: 4, data: [16 numbers, row by row]} = T_body_sensor, its rotation made exact.
  [[nodiscard]] Pose body_from_sensor() const;
  /// A matrix: {rows, cols, data} (EuRoC, OpenCV) or a list of rows (Kalibr); of exactly this size.
  [[nodiscard]] Eigen::MatrixXd matrix(const std::string& key, Eigen::Index rows, Eigen::Index cols) const;
  /// All numbers of such a matrix or of a plain list, row by row.
  [[nodiscard]] std::vector<double> entries(const std::string& key) const;
  /// A 4x4 matrix that is a rigid transform, its rotation made exact.
  [[nodiscard]] Pose transform(const std::string& key) const;

  [[nodiscard]] double not_negative(const std::string& key) const;
  [[nodiscard]] Eigen::Vector3d not_negative3(const std::string& key) const;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::size_t line(const std::string& key) const;  ///< of the value of an existing key
  [[noreturn]] void fail(const std::string& key, const std::string& expected, const std::string& found) const;

 private:
  SensorYaml(std::filesystem::path path, YAML::Node root) : path_(std::move(path)), root_(std::move(root)) {}
  [[nodiscard]] YAML::Node required(const std::string& key) const;
  [[nodiscard]] double number_of(const YAML::Node& node, const std::string& key) const;
  [[nodiscard]] std::vector<double> numbers_of(const YAML::Node& node, const std::string& key,
                                               std::optional<std::size_t> count) const;
  [[nodiscard]] Pose rigid(const YAML::Node& node, const std::string& key, const Eigen::Matrix4d& T) const;
  [[noreturn]] void fail_at(const YAML::Node& node, const std::string& expected,
                            const std::string& found) const;

  std::filesystem::path path_;
  YAML::Node root_;
};

/// Checks focal lengths, and the size where there is one; for messages `key` names where they stand.
void check_pinhole(const SensorYaml& yaml, const std::string& key, const Camera& camera);

/// [width, height] of a list.
void read_resolution(const SensorYaml& yaml, const std::string& key, Camera& camera);

/// camera_model, intrinsics, resolution, distortion_model and distortion_coefficients.
[[nodiscard]] Camera read_camera(const SensorYaml& yaml);

/// The first key of an IMU's noise that is not there.
[[nodiscard]] std::optional<std::string> missing_imu_noise(const SensorYaml& yaml);

/// gyroscope_noise_density, gyroscope_random_walk and those of the accelerometer.
[[nodiscard]] ImuNoise read_imu_noise(const SensorYaml& yaml);

/// readout_time, where there is one: from the first row to the last [s].
[[nodiscard]] double read_readout_time(const SensorYaml& yaml);

/// The value of `key` in units of `unit` [s], as a readout time of a camera.
[[nodiscard]] double checked_readout(const SensorYaml& yaml, const std::string& key, double unit);

}  // namespace limber::detail
