// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string_view>

#include "limber/datasets/recording.hpp"
#include "limber/io/atomic_file.hpp"

namespace limber::detail {

/// A folder mav0 in the making: staged beside its final name.
class EurocFolder {
 public:
  explicit EurocFolder(const std::filesystem::path& mav0) : mav0_(mav0), staged_(mav0) {}

  /// Writes a file in a subfolder, which is made if needed. @throws DataError
  void write(const std::filesystem::path& subfolder, const std::filesystem::path& name,
             std::string_view content) const;

  void write_cameras(const StereoCalibration& calibration) const;  ///< camN/sensor.yaml
  // What the recording does not hold is not written. std::invalid_argument if times do not increase or a
  // number is not finite.
  void write_imu(const Recording& recording) const;
  void write_odometry(const Recording& recording) const;
  void write_groundtruth(const Recording& recording) const;

  void commit() { staged_.replace(); }

 private:
  std::filesystem::path mav0_;
  StagedFolder staged_;
};

}  // namespace limber::detail
