// SPDX-License-Identifier: MIT
#include "limber/run_files/run_output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <system_error>

#include "io/json_text.hpp"
#include "limber/core/angle.hpp"
#include "limber/core/errors.hpp"
#include "limber/core/time.hpp"
#include "limber/datasets/landmarks_ply.hpp"
#include "limber/diagnose/run_answer.hpp"
#include "limber/io/atomic_file.hpp"
#include "limber/io/parameter_text.hpp"
#include "limber/run_files/calibration_file.hpp"
#include "limber/run_files/frames_file.hpp"
#include "limber/run_files/health_file.hpp"

namespace limber {
namespace {

using Json = nlohmann::ordered_json;

template <typename T>
Json or_null(const std::optional<T>& value) {
  return value && std::isfinite(*value) ? Json(*value) : Json(nullptr);
}

std::vector<double> in_degrees_and_metres(RigParameters theta) {
  theta.head<3>() *= kToDegrees;
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
  const ParameterSet told = told_parameters(last);
  Json out;
  for (std::size_t k = 0; k < kParameterNames.size(); ++k) {
    if (told[k]) {
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
          {"odometry_scale", or_null(options.odometry_scale)},
          {"init", name_of(options.start)},
          {"landmarks", options.landmarks == LandmarkKind::kCartesian ? "cartesian" : "inverse-depth"},
          {"gate", options.gate},
          {"max_landmarks", options.max_landmarks},
          {"points_per_update", or_null(options.points_per_update)},
          {"clean", options.cleaning.clean},
          {"max_points", options.cleaning.max_points},
          {"false_alarms_per_hour", options.false_alarms_per_hour},
          {"imu_noise", options.learn_imu_noise ? "learned" : "stated"},
          {"imu_clock", options.learn_imu_clock ? "learned" : "stated"},
          {"seed", options.seed},
          {"run", options.run}};
}

Json to_json(const std::vector<RunEvent>& events) {
  Json out = Json::array();
  for (const RunEvent& e : events) {
    out.push_back({{"what", to_string(e.kind)},
                   {"from_s", to_seconds(e.from_ns)},
                   {"to_s", to_seconds(e.to_ns)},
                   {"frames", e.frames},
                   {"samples", e.samples}});
    if (e.clock_offset_s != 0.0) {
      out.back()["clock_offset_s"] = e.clock_offset_s;
    }
  }
  return out;
}

Json to_json(const StartReport& report, const InitialState& start) {
  const auto known = [](double sigma) { return std::isfinite(sigma) ? Json(sigma) : Json(nullptr); };
  return {{"waited_s", report.waited_s},
          {"tilt_sigma_rad", known(report.tilt_sigma)},
          {"scale_sigma", known(report.scale_sigma)},
          {"clock_offset_s", to_seconds(start.clock_offset_ns)},
          {"clock_sigma_s", start.clock_sigma > 0.0 ? Json(start.clock_sigma) : Json(nullptr)},
          {"missing", report.missing}};
}

Json to_json(const PixelNoiseReport& report) {
  return {{"sigma_px", report.sigma_px},
          {"correlation", report.correlation},
          {"length_sigma", report.length_sigma}};
}

Json to_json(const ImuNoiseFactors& factors) { return {{"gyro", factors.gyro}, {"accel", factors.accel}}; }

Json to_json(const OdometryNoise& noise) {
  const auto list = [](const Eigen::Vector3d& sigma) {
    return std::vector<double>(sigma.begin(), sigma.end());
  };
  return {{"sigma_v", list(noise.sigma_v)}, {"sigma_w", list(noise.sigma_omega)}};
}

Json to_json(const FrameTime& time) { return {{"p50", time.p50}, {"p99", time.p99}, {"worst", time.worst}}; }

Json to_json(const CleaningReport& report) {
  return {{"exchanged_frames", report.exchanged_frames}, {"put_back_frames", report.put_back_frames},
          {"late_frames", report.late_frames},           {"stale_frames", report.stale_frames},
          {"stale_points", report.stale_points},         {"still_tracks", report.still_tracks},
          {"leapt_matches", report.leapt_matches},       {"rig_jumps", report.rig_jumps},
          {"thinned_frames", report.thinned_frames},     {"thinned_points", report.thinned_points},
          {"waiting_points", report.waiting_points}};
}

Json to_json(const ScaleCheck& check, std::int64_t begin_ns) {
  return {{"from_s", seconds_between(begin_ns, check.from_ns)},
          {"to_s", seconds_between(begin_ns, check.to_ns)},
          {"too_long_percent", 100.0 * check.scale.too_long},
          {"sigma_percent", 100.0 * check.scale.sigma}};
}

Json to_json(const RunAnswer& answer) {
  return {{"light", to_string(answer.light)},
          {"headline", answer.headline},
          {"sentences", answer.sentences},
          {"advice", answer.advice}};
}

Json to_json(const RunOptions& options, const RunRecord& record, const RunSummary& s) {
  Json json;
  json["method"] = s.method;
  json["dataset"] = s.dataset;
  json["answer"] = to_json(answer_of(options, record, s));
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
  json["anees_scale"] = or_null(s.anees_scale);
  json["nis_per_dof"] = or_null(s.nis_per_dof);
  json["ms_per_frame"] = {{"p50", s.ms_per_frame_p50},
                          {"p99", s.ms_per_frame_p99},
                          {"p999", s.ms_per_frame_p999},
                          {"worst", s.ms_per_frame_worst}};
  json["start_ms"] =
      s.start_ms ? Json{{"all", *s.start_ms}, {"worst", or_null(s.start_worst_ms)}} : Json(nullptr);
  json["frontend"] = nullptr;
  if (const auto& f = s.frontend) {
    json["ms_per_frame"]["decode"] = to_json(f->decode);
    json["ms_per_frame"]["track"] = to_json(f->track);
    json["ms_per_frame"]["end_to_end"] = to_json(f->end_to_end);
    json["frontend"] = {{"left_points", f->left_points},
                        {"right_points", f->right_points},
                        {"frames_per_track", f->frames_per_track}};
  }
  json["realtime_factor"] = s.realtime_factor;
  json["peak_rss_mb"] = s.peak_rss_mb;
  json["points_per_frame"] = s.points_per_frame;
  json["points_refused"] = s.points_refused;
  json["frames_by_status"] = {{to_string(UpdateStatus::kUpdated), s.inputs.updated},
                              {to_string(UpdateStatus::kEmpty), s.inputs.no_points},
                              {to_string(UpdateStatus::kSingularInnovation), s.inputs.singular}};
  json["frames_by_inputs"] = {{to_string(InputStatus::kNotNeeded), s.inputs.not_needed},
                              {to_string(InputStatus::kSound), s.inputs.sound},
                              {to_string(InputStatus::kFaulty), s.inputs.faulty},
                              {to_string(InputStatus::kGap), s.inputs.gap},
                              {to_string(InputStatus::kContradicted), s.inputs.contradicted},
                              {to_string(InputStatus::kNone), s.inputs.none}};
  json["events"] = to_json(s.inputs.events);
  json["lost_since_s"] = s.inputs.lost_since_ns ? Json(to_seconds(*s.inputs.lost_since_ns)) : Json(nullptr);
  json["health"] = s.health ? Json::parse(to_json(*s.health, watch_options(options))) : Json(nullptr);
  json["seed"] = options.seed;
  json["options"] = to_json(options);
  json["pixel_noise"] = record.pixel_noise ? to_json(*record.pixel_noise) : Json(nullptr);
  json["imu_noise"] = record.imu_noise ? to_json(*record.imu_noise) : Json(nullptr);
  json["motion_noise"] = record.motion_noise ? to_json(*record.motion_noise) : Json(nullptr);
  json["odometry_noise"] = record.odometry_noise ? to_json(*record.odometry_noise) : Json(nullptr);
  json["sensor_start"] = record.sensor_start ? to_json(*record.sensor_start, record.start) : Json(nullptr);
  json["alignment"] = s.alignment.empty() ? Json(nullptr) : Json(s.alignment);
  json["truth_tilt_deg"] = or_null(s.truth_tilt_deg);
  json["truth_is_level"] = s.truth_tilt_deg ? Json(s.truth_is_level) : Json(nullptr);
  json["theta_assumed"] = std::vector<double>(record.theta_assumed.data(), record.theta_assumed.data() + 6);
  json["theta"] = std::vector<double>(record.theta.data(), record.theta.data() + 6);
  json["estimated"] = estimated_parameters(record);
  json["complete"] = record.is_complete();
  json["frames_of_recording"] = record.frames_of_recording;
  json["frames_unreadable"] = record.frames_unreadable;
  json["readout"] = s.readout ? Json{{"ms", 1e3 * s.readout->seconds},
                                     {"sigma_ms", 1e3 * s.readout->sigma},
                                     {"explains", s.readout->explains},
                                     {"contradicts_calibration", s.readout_contradicted}}
                              : Json(nullptr);
  json["rests_on_length"] = s.rests_on_length;
  json["scale_check"] =
      s.scale_check ? to_json(*s.scale_check, record.trajectory.front().t_ns) : Json(nullptr);
  json["cleaning"] = to_json(record.cleaning);
  json["notes"] = record.notes;
  return json;
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

const std::vector<std::string>& run_file_names() {
  static const std::vector<std::string> kNames = {
      "trajectory.tum",  "trajectory.csv", "landmarks.ply", "frames.csv",   "refusals.csv",     "health.csv",
      "calibration.csv", "truth.tum",      "truth.csv",     "summary.json", "health_state.json"};
  return kNames;
}

std::string summary_json(const RunOptions& options, const RunRecord& record, const RunSummary& summary) {
  return detail::json_text(to_json(options, record, summary), 2) + "\n";
}

void write_run_output(const std::filesystem::path& folder, const RunOptions& options, const RunRecord& record,
                      const RunSummary& summary) {
  const std::vector<StampedPose> poses = poses_of(record.trajectory);
  try {
    const FolderUnlessEmpty outer(folder);
    StagedFolder staged(folder / "results");
    std::vector<std::string> names = {"trajectory.tum", "trajectory.csv", "landmarks.ply", "frames.csv",
                                      "refusals.csv"};
    write_tum(staged.path() / "trajectory.tum", poses);
    write_trajectory_csv(staged.path() / "trajectory.csv", record.trajectory);
    write_landmarks_ply(staged.path() / "landmarks.ply", record.landmarks);
    write_frames_csv(staged.path() / "frames.csv", record);
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
    if (!summary.truth_motion.states.empty()) {
      write_euroc_groundtruth(staged.path() / "truth.csv", summary.truth_motion);
      names.emplace_back("truth.csv");
    }
    write_file_atomically(staged.path() / "summary.json", summary_json(options, record, summary));
    names.emplace_back("summary.json");
    // An older run's must not stand beside new files; without a summary they are no run.
    std::filesystem::remove(folder / "summary.json");
    for (const std::string& name : run_file_names()) {
      if (std::ranges::find(names, name) == names.end()) {
        std::filesystem::remove(folder / name);
      }
    }
    staged.move_files(names, folder);
  } catch (const std::filesystem::filesystem_error& error) {
    throw DataError(folder.string(), 0, "a folder that can be made and written", error.code().message());
  }
}

}  // namespace limber
