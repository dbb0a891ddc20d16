// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <initializer_list>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "limber/core/time.hpp"
#include "limber/datasets/trajectory_files.hpp"
#include "limber/evaluate/association.hpp"
#include "limber/evaluate/consistency.hpp"
#include "limber/run_files/calibration_file.hpp"
#include "limber/run_files/frames_file.hpp"
#include "limber/run_files/health_file.hpp"

namespace limber::detail {

using Json = nlohmann::ordered_json;

/// The files of a run's folder, read.
struct RunFolder {
  std::filesystem::path path;
  std::string method;
  Json summary;  ///< an object
  std::vector<TrajectoryRow> trajectory;
  std::vector<FrameRow> frames;             ///< as many as trajectory, at the same times
  std::vector<HealthRow> health;            ///< empty where the calibration was not watched
  std::vector<CalibrationRow> calibration;  ///< empty where it was not estimated
  std::map<std::int64_t, Eigen::Vector3d> landmarks;
  std::vector<MatchedPose> matched;  ///< with the truth; empty where it is not known
  GroundTruth truth_motion;          ///< truth.csv; empty where there is none

  /// Seconds since the first frame.
  [[nodiscard]] double seconds(std::int64_t t_ns) const {
    return seconds_between(trajectory.front().t_ns, t_ns);
  }
};

/// A number of summary.json, by keys from the outside in; nothing where it is not known.
[[nodiscard]] std::optional<double> number_at(const Json& json, std::initializer_list<const char*> keys);

/// @throws DataError if a file is missing or cannot be used, or files belong to different runs
[[nodiscard]] RunFolder read_run_folder(const std::filesystem::path& path);

}  // namespace limber::detail
