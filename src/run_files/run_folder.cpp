// SPDX-License-Identifier: MIT
#include "run_files/run_folder.hpp"

#include <fmt/format.h>

#include <optional>

#include "io/json_text.hpp"
#include "io/text_file.hpp"
#include "limber/core/errors.hpp"
#include "limber/datasets/landmarks_ply.hpp"

namespace limber::detail {
namespace {

namespace fs = std::filesystem;

constexpr double kSameTime = 1e-9;  // [s]

Json read_summary(const fs::path& path) {
  const Json json = parse_json<Json>(load_text(path), path.string());
  if (!json.is_object() || !json.contains("method") || !json.at("method").is_string()) {
    throw DataError(path.string(), 0, "an object with the string 'method'", "other JSON");
  }
  return json;
}

std::vector<MatchedPose> match_truth(const RunFolder& folder, const fs::path& path) {
  if (!fs::exists(path)) {
    return {};
  }
  std::vector<StampedPose> estimate;
  for (const TrajectoryRow& row : folder.trajectory) {
    estimate.push_back({row.t_ns, row.T_world_body});
  }
  std::vector<MatchedPose> matched = match_by_time(estimate, read_tum(path), kSameTime);
  if (matched.empty()) {
    throw DataError(path.string(), 0, "the truth at times of trajectory.csv", "other times");
  }
  return matched;
}

}  // namespace

std::optional<double> number_at(const Json& json, std::initializer_list<const char*> keys) {
  const Json* at = &json;
  for (const char* const key : keys) {
    const auto it = at->is_object() ? at->find(key) : at->end();
    if (!at->is_object() || it == at->end()) {
      return std::nullopt;
    }
    at = &*it;
  }
  return at->is_number() ? std::optional(at->get<double>()) : std::nullopt;
}

RunFolder read_run_folder(const fs::path& path) {
  RunFolder folder;
  folder.path = path;
  folder.summary = read_summary(path / "summary.json");
  folder.method = folder.summary["method"].get<std::string>();
  folder.trajectory = read_trajectory_csv(path / "trajectory.csv");
  folder.frames = read_frames_csv(path / "frames.csv");
  if (folder.frames.size() != folder.trajectory.size() ||
      folder.frames.front().t_ns != folder.trajectory.front().t_ns) {
    throw DataError((path / "frames.csv").string(), 0,
                    fmt::format("the {} frames of trajectory.csv", folder.trajectory.size()),
                    fmt::format("{} frames", folder.frames.size()));
  }
  if (fs::exists(path / "health.csv")) {
    folder.health = read_health_csv(path / "health.csv");
  }
  if (fs::exists(path / "calibration.csv")) {
    folder.calibration = read_calibration_csv(path / "calibration.csv");
  }
  folder.landmarks = read_landmarks_ply(path / "landmarks.ply");
  folder.matched = match_truth(folder, path / "truth.tum");
  return folder;
}

}  // namespace limber::detail
