// SPDX-License-Identifier: MIT
#include "limber/run/run_output.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numeric>
#include <system_error>

#include "limber/core/errors.hpp"
#include "limber/core/so3.hpp"
#include "limber/datasets/atomic_file.hpp"
#include "limber/datasets/landmarks_ply.hpp"
#include "limber/evaluate/consistency.hpp"
#include "limber/evaluate/evaluation.hpp"
#include "limber/run/health_file.hpp"
#include "limber/run/parameter_text.hpp"

namespace limber {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegreesPerRadian = 180.0 / M_PI;

double quantile(std::vector<double> values, double share) {
  if (values.empty()) {
    return 0.0;
  }
  const auto k = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + k, values.end());
  return values[static_cast<std::size_t>(k)];
}

double peak_rss_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;  // Linux: KiB
}

/// Takes the whole first pose out: the world of a run without gravity is its first camera.
Alignment first_whole_pose(const std::vector<MatchedPose>& poses) {
  Alignment out;
  out.T_true_est = poses.front().truth * poses.front().estimate.inverse();
  return out;
}

struct StartAlignment {
  Alignment alignment;
  std::string in_words;
};

StartAlignment start_alignment(const std::vector<MatchedPose>& poses, const RunOptions& options,
                               MotionModel motion) {
  if (options.start == StartMode::kGroundTruth) {
    return {{}, "nothing"};
  }
  return motion == MotionModel::kImu
             ? StartAlignment{align(poses, AlignmentKind::kFirstPose), "position and yaw of the first pose"}
             : StartAlignment{first_whole_pose(poses), "whole first pose"};
}

/// The truth in the world of the estimate; `alignment` is rigid.
std::vector<StampedPose> truth_seen_from(const std::vector<MatchedPose>& poses, const Alignment& alignment) {
  const Pose T_est_true = alignment.T_true_est.inverse();
  std::vector<StampedPose> out;
  for (const MatchedPose& pose : poses) {
    out.push_back({pose.t_ns, T_est_true * pose.truth});
  }
  return out;
}

void judge(const Recording& recording, const RunOptions& options, const RunRecord& record, RunSummary& out) {
  std::vector<StampedPose> estimate, truth;
  std::vector<PoseCovariance> covariances;
  for (const TrajectoryRow& row : record.trajectory) {
    estimate.push_back({row.t_ns, row.T_world_body});
    covariances.push_back(*row.covariance);
  }
  for (const GroundTruthState& state : recording.groundtruth) {
    truth.push_back({state.t_ns, {state.R_world_body, state.p_world_body}});
  }
  const std::vector<MatchedPose> poses = match_by_time(estimate, truth);
  if (poses.empty()) {
    return;
  }
  const TrajectoryEvaluation evaluation = evaluate_trajectory(poses);
  const auto rmse = [](const AlignedErrors& errors) {
    return errors.errors ? std::optional(errors.errors->position_m.rmse) : std::nullopt;
  };
  out.path_length_m = evaluation.path_length;
  out.ate_none_m = rmse(evaluation.none);
  out.ate_se3_m = rmse(evaluation.se3);
  out.ate_sim3_m = rmse(evaluation.sim3);
  if (evaluation.sim3.errors) {
    out.scale = evaluation.sim3.alignment.scale;
  }
  const auto [start, in_words] = start_alignment(poses, options, record.motion);
  out.alignment = in_words;
  out.truth = truth_seen_from(poses, start);
  const PoseErrorStatistics errors = absolute_errors(poses, start);
  out.position_rmse_m = errors.position_m.rmse;
  out.attitude_rmse_deg = errors.attitude_deg.rmse;
  out.position_max_m = errors.position_m.max;
  out.attitude_max_deg = errors.attitude_deg.max;
  const PoseErrorVector last = pose_error(start * poses.back().estimate, poses.back().truth);
  out.position_final_m = last.head<3>().norm();
  out.attitude_final_deg = last.tail<3>().norm() * kDegreesPerRadian;
  const Consistency consistency = average_nees(poses, covariances, start, estimate.front().t_ns);
  out.frames_refused = consistency.frames_refused;
  if (consistency.anees) {
    out.anees = consistency.anees->pose;
    out.anees_position = consistency.anees->position;
    out.anees_attitude = consistency.anees->attitude;
    out.share_within_95 = consistency.share_within_95;
  }
}

double estimated_length(const RunRecord& record) {
  double length = 0.0;
  for (std::size_t k = 1; k < record.trajectory.size(); ++k) {
    length += (record.trajectory[k].T_world_body.p - record.trajectory[k - 1].T_world_body.p).norm();
  }
  return length;
}

template <typename T>
Json or_null(const std::optional<T>& value) {
  return value && std::isfinite(*value) ? Json(*value) : Json(nullptr);
}

std::vector<double> in_degrees_and_metres(RigParameters theta) {
  theta.head<3>() *= kDegreesPerRadian;
  return {theta.data(), theta.data() + theta.size()};
}

Json text_or_null(const ParameterVector& parameters) {
  return parameters.isZero(0.0) ? Json(nullptr) : Json(format_parameters(parameters));
}

/// True minus assumed after the last frame, by name; null where nothing was estimated.
Json estimated_parameters(const RunRecord& record) {
  if (record.calibration.empty()) {
    return nullptr;
  }
  const CalibrationEstimate& last = record.calibration.back().estimate;
  Json out;
  for (std::size_t k = 0; k < kParameterNames.size(); ++k) {
    if (last.parameters[k]) {
      const auto at = static_cast<Eigen::Index>(k);
      out[std::string(kParameterNames[k])] = {{"error", in_user_units(k, last.error(at))},
                                              {"sigma", in_user_units(k, last.sigma(at))},
                                              {"unit", user_unit_of(k)}};
    }
  }
  return out;
}

/// What the user chose; null where limber chose (`notes` say what).
Json to_json(const RunOptions& options) {
  return {{"method", to_string(options.method)},
          {"constraints", options.constraints ? Json(to_string(*options.constraints)) : Json(nullptr)},
          {"assume_error_deg_m", in_degrees_and_metres(options.assume_error.head<6>())},
          {"assume_error", text_or_null(options.assume_error)},
          {"estimate", text_or_null(options.estimated)},
          {"soften", text_or_null(options.softened)},
          {"sigma_px", or_null(options.sigma_px)},
          {"init", options.start == StartMode::kGroundTruth ? "groundtruth" : "auto"},
          {"landmarks", options.landmarks == LandmarkKind::kCartesian ? "cartesian" : "inverse-depth"},
          {"gate", options.gate},
          {"max_landmarks", options.max_landmarks},
          {"false_alarms_per_hour", options.false_alarms_per_hour},
          {"seed", options.seed},
          {"run", options.run}};
}

Json to_json(const RunOptions& options, const RunRecord& record, const RunSummary& s) {
  Json json;
  json["method"] = s.method;
  json["dataset"] = s.dataset;
  json["frames"] = s.frames;
  json["duration_s"] = s.duration_s;
  json["path_length_m"] = s.path_length_m;
  json["ate_m"] = {{"none", or_null(s.ate_none_m)},
                   {"se3", or_null(s.ate_se3_m)},
                   {"sim3", or_null(s.ate_sim3_m)},
                   {"scale", or_null(s.scale)}};
  json["position_rmse_m"] = or_null(s.position_rmse_m);
  json["attitude_rmse_deg"] = or_null(s.attitude_rmse_deg);
  json["anees"] = or_null(s.anees);
  json["anees_position"] = or_null(s.anees_position);
  json["anees_attitude"] = or_null(s.anees_attitude);
  json["nis_per_dof"] = or_null(s.nis_per_dof);
  json["ms_per_frame"] = {{"p50", s.ms_per_frame_p50}, {"p99", s.ms_per_frame_p99}};
  json["realtime_factor"] = s.realtime_factor;
  json["peak_rss_mb"] = s.peak_rss_mb;
  json["points_per_frame"] = s.points_per_frame;
  json["points_refused"] = s.points_refused;
  json["health"] = s.health ? Json::parse(to_json(*s.health, options.false_alarms_per_hour)) : Json(nullptr);
  json["seed"] = options.seed;
  json["options"] = to_json(options);
  json["alignment"] = s.alignment.empty() ? Json(nullptr) : Json(s.alignment);
  json["theta"] = std::vector<double>(record.theta.data(), record.theta.data() + 6);
  json["estimated"] = estimated_parameters(record);
  json["notes"] = record.notes;
  return json;
}

std::string frames_csv(const RunRecord& record) {
  std::string text =
      "#t_ns,observed,used,initialized,removed,refused,gate_overruled,nis "
      "[-],dof,constrained_rank,filter_ms,source_ms\n";
  auto out = std::back_inserter(text);
  for (std::size_t k = 0; k < record.frames.size(); ++k) {
    const FrameReport& f = record.frames[k];
    fmt::format_to(out, "{},{},{},{},{},{},{:d},{},{},{},{:.3f},{:.3f}\n", f.t_ns, f.observed, f.used,
                   f.initialized, f.removed, f.refused.size(), f.gate_overruled, f.nis, f.dof, f.rank,
                   record.frame_ms[k], record.source_ms[k]);
  }
  return text;
}

std::string refusals_csv(const RunRecord& record) {
  std::string text = "#t_ns,track_id,reason,squared_distance [-],threshold [-]\n";
  auto out = std::back_inserter(text);
  for (const FrameReport& f : record.frames) {
    for (const Refusal& r : f.refused) {
      fmt::format_to(out, "{},{},{},{},{}\n", f.t_ns, r.track_id,
                     r.reason == RefusalReason::kGate ? "gate" : "not-projectable", r.distance, r.threshold);
    }
  }
  return text;
}

}  // namespace

RunSummary summarize(const Recording& recording, const RunOptions& options, const RunRecord& record) {
  RunSummary out;
  out.method = to_string(options.method);
  out.dataset = recording.name;
  out.frames = record.trajectory.size();
  out.duration_s = 1e-9 * static_cast<double>(record.trajectory.back().t_ns - record.trajectory.front().t_ns);
  out.path_length_m = estimated_length(record);
  if (!recording.groundtruth.empty()) {
    judge(recording, options, record, out);
  }
  double used = 0.0;
  for (const FrameReport& frame : record.frames) {
    out.nis += frame.nis;
    out.nis_dof += static_cast<double>(frame.dof);
    used += static_cast<double>(frame.used);
    out.points_refused += frame.refused.size();
  }
  if (out.nis_dof > 0.0) {
    out.nis_per_dof = out.nis / out.nis_dof;
  }
  out.points_per_frame = used / static_cast<double>(out.frames);
  out.ms_per_frame_p50 = quantile(record.frame_ms, 0.5);
  out.ms_per_frame_p99 = quantile(record.frame_ms, 0.99);
  const double filter_ms = std::accumulate(record.frame_ms.begin(), record.frame_ms.end(), 0.0);
  out.ms_per_frame_mean = filter_ms / static_cast<double>(out.frames);
  const double spent_ms = filter_ms + std::accumulate(record.source_ms.begin(), record.source_ms.end(), 0.0);
  out.realtime_factor = spent_ms > 0.0 ? 1e3 * out.duration_s / spent_ms : 0.0;
  out.peak_rss_mb = peak_rss_mb();
  out.health = summarize_health(record.frames);
  return out;
}

void write_run_output(const std::filesystem::path& folder, const RunOptions& options, const RunRecord& record,
                      const RunSummary& summary) {
  std::vector<StampedPose> poses;
  for (const TrajectoryRow& row : record.trajectory) {
    poses.push_back({row.t_ns, row.T_world_body});
  }
  try {
    const FolderUnlessEmpty outer(folder);
    StagedFolder staged(folder / "results");
    std::vector<std::string> names = {"trajectory.tum", "trajectory.csv", "landmarks.ply", "frames.csv",
                                      "refusals.csv"};
    write_tum(staged.path() / "trajectory.tum", poses);
    write_trajectory_csv(staged.path() / "trajectory.csv", record.trajectory);
    write_landmarks_ply(staged.path() / "landmarks.ply", record.landmarks);
    write_file_atomically(staged.path() / "frames.csv", frames_csv(record));
    write_file_atomically(staged.path() / "refusals.csv", refusals_csv(record));
    if (summary.health) {
      write_health_csv(staged.path() / "health.csv", record.frames);
      names.emplace_back("health.csv");
    }
    if (!record.calibration.empty()) {
      write_calibration_csv(staged.path() / "calibration.csv", record.calibration);
      names.emplace_back("calibration.csv");
    }
    if (!summary.truth.empty()) {
      write_tum(staged.path() / "truth.tum", summary.truth);
      names.emplace_back("truth.tum");
    }
    write_file_atomically(staged.path() / "summary.json", to_json(options, record, summary).dump(2) + "\n");
    names.emplace_back("summary.json");
    // An older run's must not stand beside new files.
    std::filesystem::remove(folder / "summary.json");
    std::filesystem::remove(folder / "truth.tum");
    std::filesystem::remove(folder / "health.csv");
    std::filesystem::remove(folder / "calibration.csv");
    staged.move_files(names, folder);
  } catch (const std::filesystem::filesystem_error& error) {
    throw DataError(folder.string(), 0, "a folder that can be made and written", error.code().message());
  }
}

}  // namespace limber
