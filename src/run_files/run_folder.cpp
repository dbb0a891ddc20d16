// SPDX-License-Identifier: MIT
#include "run_files/run_folder.hpp"

#include <fmt/format.h>

#include <numbers>
#include <optional>

#include "io/json_text.hpp"
#include "io/text_file.hpp"
#include "limber/core/errors.hpp"
#include "limber/datasets/landmarks_ply.hpp"
#include "limber/diagnose/run_summary.hpp"
#include "limber/evaluate/trajectory_error.hpp"
#include "limber/evaluate/world_tilt.hpp"

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
  std::vector<MatchedPose> matched = match_by_time(poses_of(folder.trajectory), read_tum(path), kSameTime);
  if (matched.empty()) {
    throw DataError(path.string(), 0, "the truth at times of trajectory.csv", "other times");
  }
  return matched;
}

/// Older versions left the tilt of a truth's world in the errors: takes it out, and says so in the summary.
void set_truth_upright(RunFolder& folder) {
  if (folder.matched.empty() ||
      folder.summary.value("alignment", Json()) != std::string(kFirstPoseAlignment)) {
    return;
  }
  std::vector<PoseCovariance> covariances;
  for (const TrajectoryRow& row : folder.trajectory) {
    covariances.push_back(row.covariance.value_or(PoseCovariance::Zero()));
  }
  const auto tilt = world_tilt(folder.matched, covariances);
  if (!tilt || !tilt->is_askew()) {
    return;
  }
  const auto [alignment, in_words] = upright_alignment(folder.matched, *tilt);
  const Pose T_est_true = alignment.T_true_est.inverse();
  for (MatchedPose& pose : folder.matched) {
    pose.truth = T_est_true * pose.truth;
  }
  const PoseErrorStatistics errors = absolute_errors(folder.matched, {});
  const Consistency consistency =
      average_nees(folder.matched, covariances, {}, folder.trajectory.front().t_ns);
  Json& summary = folder.summary;
  summary["alignment"] = in_words;
  summary["truth_tilt_deg"] = tilt->angle * 180.0 / std::numbers::pi;
  summary["truth_is_level"] = false;
  summary["position_rmse_m"] = errors.position_m.rmse;
  summary["attitude_rmse_deg"] = errors.attitude_deg.rmse;
  const auto part = [&consistency](double PoseNees::*which) {
    return consistency.anees ? Json((*consistency.anees).*which) : Json(nullptr);
  };
  summary["anees"] = part(&PoseNees::pose);
  summary["anees_position"] = part(&PoseNees::position);
  summary["anees_attitude"] = part(&PoseNees::attitude);
  summary["anees_scale"] = consistency.anees_scale ? Json(*consistency.anees_scale) : Json(nullptr);
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
  if (fs::exists(path / "truth.csv")) {
    folder.truth_motion = read_euroc_groundtruth(path / "truth.csv");
  }
  set_truth_upright(folder);
  return folder;
}

}  // namespace limber::detail
