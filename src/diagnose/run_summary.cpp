// SPDX-License-Identifier: MIT
#include "limber/diagnose/run_summary.hpp"

#include <sys/resource.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <span>
#include <utility>

#include "limber/core/angle.hpp"
#include "limber/core/median.hpp"
#include "limber/core/time.hpp"
#include "limber/datasets/interpolate.hpp"
#include "limber/evaluate/consistency.hpp"
#include "limber/evaluate/evaluation.hpp"

namespace limber {
namespace {

double sum(std::span<const double> values) { return std::accumulate(values.begin(), values.end(), 0.0); }

/// The filter's times and those of the start, which is none of its frames.
void summarize_times(const RunRecord& record, RunSummary& out) {
  const auto begin = record.frame_ms.begin() + static_cast<std::ptrdiff_t>(record.frames_of_start);
  const std::vector<double> start(record.frame_ms.begin(), begin);
  const std::vector<double> filter(begin, record.frame_ms.end());
  if (!start.empty()) {
    out.start_ms = sum(start);
    out.start_worst_ms = quantile(start, 1.0);
  }
  if (!filter.empty()) {
    out.ms_per_frame_p50 = quantile(filter, 0.5);
    out.ms_per_frame_p99 = quantile(filter, 0.99);
    out.ms_per_frame_p999 = quantile(filter, 0.999);
    out.ms_per_frame_worst = quantile(filter, 1.0);
    out.ms_per_frame_mean = sum(filter) / static_cast<double>(filter.size());
  }
}

double peak_rss_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;  // Linux: KiB
}

/// Takes the whole first pose out: the world of a run without gravity is its first camera.
Alignment first_whole_pose(std::span<const MatchedPose> poses) {
  Alignment out;
  out.T_true_est = poses.front().truth * poses.front().estimate.inverse();
  return out;
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

/// The same with what the recording knows of velocity and biases.
GroundTruth motion_seen_from(const Recording& recording, const std::vector<MatchedPose>& poses,
                             const Alignment& alignment) {
  GroundTruth out;
  if (!recording.truth.motion.has_velocity && !recording.truth.motion.has_biases) {
    return out;
  }
  out.has_velocity = recording.truth.motion.has_velocity;
  out.has_biases = recording.truth.motion.has_biases;
  const Pose T_est_true = alignment.T_true_est.inverse();
  for (const MatchedPose& pose : poses) {
    GroundTruthState state = groundtruth_at(recording.truth.motion.states, pose.t_ns).value();
    const Pose seen = T_est_true * pose.truth;
    state.R_world_body = seen.R;
    state.p_world_body = seen.p;
    state.v_world_body = T_est_true.R * state.v_world_body;
    out.states.push_back(state);
  }
  return out;
}

/// What is taken out before errors are counted; says what it finds of the truth's world.
Alignment alignment_of(std::span<const MatchedPose> poses, std::span<const PoseCovariance> covariances,
                       StartMode start, MotionModel motion, RunSummary& out) {
  StartAlignment taken = start_alignment(poses, start, motion);
  if (taken.in_words == kFirstPoseAlignment) {
    if (const auto tilt = world_tilt(poses, covariances)) {
      out.truth_tilt_deg = kToDegrees * tilt->angle;
      out.truth_is_level = !tilt->is_askew();
      taken = out.truth_is_level ? taken : upright_alignment(poses, *tilt);
    }
  }
  out.alignment = taken.in_words;
  return taken.alignment;
}

void judge(const Recording& recording, const RunOptions& options, const RunRecord& record, RunSummary& out) {
  std::vector<PoseCovariance> covariances;
  for (const TrajectoryRow& row : record.trajectory) {
    covariances.push_back(*row.covariance);
  }
  const std::vector<MatchedPose> poses =
      match_by_time(poses_of(record.trajectory), poses_of(recording.truth.motion.states));
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
  const Alignment start = alignment_of(poses, covariances, options.start, record.motion, out);
  out.truth = truth_seen_from(poses, start);
  out.truth_motion = motion_seen_from(recording, poses, start);
  const PoseErrorStatistics errors = absolute_errors(poses, start);
  out.position_rmse_m = errors.position_m.rmse;
  out.attitude_rmse_deg = errors.attitude_deg.rmse;
  out.position_max_m = errors.position_m.max;
  out.attitude_max_deg = errors.attitude_deg.max;
  const PoseErrorVector last = pose_error(start * poses.back().estimate, poses.back().truth);
  out.position_final_m = last.head<3>().norm();
  out.attitude_final_deg = last.tail<3>().norm() * kToDegrees;
  const Consistency consistency = average_nees(poses, covariances, start, record.trajectory.front().t_ns);
  out.frames_refused = consistency.frames_refused;
  out.anees_scale = consistency.anees_scale;
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

FrameTime frame_time(const std::vector<double>& ms) {
  if (ms.empty()) {
    return {};
  }
  return {quantile(ms, 0.5), quantile(ms, 0.99), quantile(ms, 1.0)};
}

/// Of each frame of the run, what reading, tracking and filtering it took.
std::vector<double> end_to_end_ms(const FrontendRecord& frontend, const RunRecord& record) {
  std::map<std::int64_t, double> filter_ms;
  for (std::size_t k = 0; k < record.trajectory.size(); ++k) {
    filter_ms[record.trajectory[k].t_ns] = record.frame_ms[k];
  }
  std::vector<double> ms;
  for (std::size_t k = 0; k < frontend.t_ns.size(); ++k) {
    const auto filter = filter_ms.find(frontend.t_ns[k]);
    if (filter != filter_ms.end())
      ms.push_back(frontend.decode_ms[k] + frontend.track_ms[k] + filter->second);
  }
  return ms;
}

std::optional<FrontendSummary> summarize_frontend(const RunRecord& record) {
  if (!record.frontend || record.frontend->t_ns.empty()) return std::nullopt;
  const FrontendRecord& frontend = *record.frontend;
  const auto frames = static_cast<double>(frontend.t_ns.size());
  FrontendSummary out;
  out.decode = frame_time(frontend.decode_ms);
  out.track = frame_time(frontend.track_ms);
  out.end_to_end = frame_time(end_to_end_ms(frontend, record));
  out.left_points = static_cast<double>(frontend.left_points) / frames;
  out.right_points = static_cast<double>(frontend.right_points) / frames;
  if (!frontend.tracks.empty()) {
    out.frames_per_track =
        static_cast<double>(frontend.left_points) / static_cast<double>(frontend.tracks.size());
  }
  return out;
}

}  // namespace

StartAlignment start_alignment(std::span<const MatchedPose> poses, StartMode start, MotionModel motion) {
  if (start == StartMode::kGroundTruth) {
    return {{}, "nothing"};
  }
  return motion == MotionModel::kImu
             ? StartAlignment{align(poses, AlignmentKind::kFirstPose), std::string(kFirstPoseAlignment)}
             : StartAlignment{first_whole_pose(poses), "whole first pose"};
}

StartAlignment upright_alignment(std::span<const MatchedPose> poses, const WorldTilt& tilt) {
  return {align_upright(poses, tilt), fmt::format("tilt of the truth's world ({:.1f} deg), then {}",
                                                  kToDegrees * tilt.angle, kFirstPoseAlignment)};
}

void add_readout(const std::optional<ReadoutTime>& readout, const StereoCalibration& assumed,
                 RunRecord& record, RunSummary& summary) {
  summary.readout = readout;
  summary.readout_contradicted = readout && contradicts(*readout, assumed);
  if (!summary.readout_contradicted) {
    return;
  }
  record.notes.insert(record.notes.begin(), in_words(*readout, assumed) +
                                                "; until then poses are wrong by more than their sigmas say");
  if (summary.health) {
    summary.health->verdict = HealthVerdict::kCannotTell;
  }
}

void add_offsets(const SensorOffsets& offsets, RunSummary& summary) {
  summary.clock_mistakes = clock_mistakes(offsets);
  summary.corrected_clock = corrected_clock_in_words(offsets);
  summary.camera_imu_mistakes = camera_imu_mistakes(offsets);
  if (summary.health) {
    const HealthVerdict beside = verdict_beside(offsets, *summary.health);
    summary.clocks_hide_rig =
        beside == HealthVerdict::kCannotTell && summary.health->verdict != HealthVerdict::kCannotTell;
    summary.health->verdict = beside;
  }
}

bool is_trustworthy(const RunSummary& summary) {
  return summary.mistakes.empty() && !summary.inputs.lost_since_ns && !summary.readout_contradicted &&
         std::ranges::all_of(summary.camera_imu_mistakes, &OffsetMistake::sigmas_hold);
}

RunSummary summarize(const Recording& recording, const RunOptions& options, const RunRecord& record) {
  RunSummary out;
  out.method = to_string(options.method);
  out.dataset = recording.name;
  out.frames = record.trajectory.size();
  out.duration_s = seconds_between(record.trajectory.front().t_ns, record.trajectory.back().t_ns);
  out.path_length_m = estimated_length(record);
  if (!recording.truth.motion.states.empty()) {
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
  summarize_times(record, out);
  out.frontend = summarize_frontend(record);
  // Where the front end works beside the filter, the times of both do not add up.
  const double spent_ms =
      record.frontend ? 1e3 * record.elapsed_s : sum(record.frame_ms) + sum(record.source_ms);
  out.realtime_factor = spent_ms > 0.0 ? 1e3 * out.duration_s / spent_ms : 0.0;
  out.peak_rss_mb = peak_rss_mb();
  out.inputs = summarize_inputs(record.frames);
  out.health = summarize_health(record.frames);
  return out;
}

}  // namespace limber
