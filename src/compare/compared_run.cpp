// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "compare_folders.hpp"
#include "limber/core/time.hpp"
#include "limber/evaluate/evaluation.hpp"

namespace limber::detail {
namespace {

constexpr double kFewPieces = 10.0, kShortestPiece = 1.0;  // [-], [s]

double mean_of(const std::vector<RelativeError>& errors, double RelativeError::*part) {
  double sum = 0.0;
  for (const RelativeError& error : errors) {
    sum += error.*part;
  }
  return sum / static_cast<double>(errors.size());
}

void judge_by_truth(const RunFolder& run, ComparedRun& out) {
  const TrajectoryEvaluation evaluation = evaluate_trajectory(run.matched);
  // What truth.tum says is aligned as the run's own errors.
  const AlignedErrors& own = evaluation.none;
  out.path_length_m = evaluation.path_length;
  out.ate_m = (evaluation.se3.errors ? evaluation.se3 : own).errors->position_m.rmse;
  out.attitude_rmse_deg = own.errors->attitude_deg.rmse;
  out.truth_is_tilted = run.summary.value("truth_is_level", Json()) == false;
  if (evaluation.sim3.errors) {
    out.scale_error_percent = 100.0 * (1.0 / evaluation.sim3.alignment.scale - 1.0);
  }
  out.anees = number_at(run.summary, {"anees"});
  const std::vector<RelativeError> errors =
      relative_errors_of(run.matched, disjoint_pieces(run.matched, out.piece_m));
  out.pieces = errors.size();
  if (!errors.empty()) {
    out.rpe_percent = 100.0 * mean_of(errors, &RelativeError::position_m) / out.piece_m;
    out.rpe_deg = mean_of(errors, &RelativeError::attitude_deg);
  }
}

RunEnd end_of(const ComparedRun& run, const Json& summary) {
  return run.lost_since_s                                 ? RunEnd::kLost
         : summary.value("complete", Json(true)) == false ? RunEnd::kPartial
                                                          : RunEnd::kDone;
}

}  // namespace

std::vector<MatchedPose> poses_on_path(const RunFolder& run) {
  if (!run.matched.empty()) {
    return run.matched;
  }
  std::vector<MatchedPose> poses;
  for (const TrajectoryRow& row : run.trajectory) {
    poses.push_back({row.t_ns, poses.size(), row.T_world_body, row.T_world_body});
  }
  return poses;
}

double default_piece(std::span<const MatchedPose> poses) {
  const double length = true_path_length(poses);
  const double duration = seconds_between(poses.front().t_ns, poses.back().t_ns);
  const double pieces = std::min(kFewPieces, duration / kShortestPiece);
  if (!(length > 0.0) || !(pieces >= 1.0)) {
    return 1.0;
  }
  // The largest of 1, 2, 5, 10, ... that is no longer.
  const double decade = std::pow(10.0, std::floor(std::log10(length / pieces)));
  const double digit = length / pieces / decade;
  return decade * (digit >= 5.0 ? 5.0 : digit >= 2.0 ? 2.0 : 1.0);
}

ComparedRun compared_run(const RunFolder& run, double piece_m) {
  ComparedRun out;
  out.folder = run.path;
  out.method = run.method;
  const Json name = run.summary.value("dataset", Json(""));
  out.recording = name.is_string() ? name.get<std::string>() : name.dump();
  out.frames = run.frames.size();
  out.frames_of_recording = static_cast<std::size_t>(
      number_at(run.summary, {"frames_of_recording"}).value_or(static_cast<double>(out.frames)));
  out.duration_s = run.seconds(run.trajectory.back().t_ns);
  if (const auto lost = number_at(run.summary, {"lost_since_s"})) {
    out.lost_since_s = *lost - to_seconds(run.trajectory.front().t_ns);
  }
  out.end = end_of(out, run.summary);
  out.has_truth = !run.matched.empty();
  out.piece_m = piece_m;
  if (out.has_truth) {
    judge_by_truth(run, out);
  } else {
    out.path_length_m = true_path_length(poses_on_path(run));
  }
  const Json health = run.summary.value("health", Json());
  if (health.is_object() && health.value("verdict", Json()).is_string()) {
    out.verdict = health.value("verdict", "");
  }
  out.ms_per_frame = number_at(run.summary, {"ms_per_frame", "p50"});
  out.ms_per_frame_p99 = number_at(run.summary, {"ms_per_frame", "p99"});
  return out;
}

}  // namespace limber::detail
