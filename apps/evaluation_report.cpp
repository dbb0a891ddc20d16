// SPDX-License-Identifier: MIT
#include "evaluation_report.hpp"

#include <fmt/format.h>

#include <iterator>
#include <string_view>

#include "limber/core/angle.hpp"

namespace limber::app {
namespace {

using Text = std::back_insert_iterator<std::string>;

Json errors_json(const std::optional<PoseErrorStatistics>& errors) {
  return errors ? Json{{"translation_m", to_json(errors->position_m)},
                       {"rotation_deg", to_json(errors->attitude_deg)}}
                : Json(nullptr);
}

Json errors_json(const AlignedErrors& aligned) {
  if (!aligned.errors) {
    return {{"alignment", describe(aligned.alignment.status)},
            {"translation_m", nullptr},
            {"rotation_deg", nullptr}};
  }
  Json json = errors_json(aligned.errors);
  json["scale"] = aligned.alignment.scale;
  return json;
}

Json rmse_json(const AlignedErrors& aligned) {
  return aligned.errors ? Json(aligned.errors->position_m.rmse) : Json(nullptr);
}

std::string distance_name(const RelativeErrorSettings& settings) {
  return fmt::format("{:g} m", settings.distance);
}

// One line of a table of errors: five columns for position, five for attitude.
void add_row(Text out, std::string_view name, const PoseErrorStatistics& errors) {
  fmt::format_to(out, "{:<11}", name);
  for (const Statistics* s : {&errors.position_m, &errors.attitude_deg}) {
    fmt::format_to(out, "{:>10.4g}{:>10.4g}{:>10.4g}{:>10.4g}{:>10.4g}", s->rmse, s->mean, s->median, s->std,
                   s->max);
  }
  fmt::format_to(out, "\n");
}

void add_row(Text out, std::string_view name, const AlignedErrors& aligned) {
  if (aligned.errors) {
    add_row(out, name, *aligned.errors);
  } else {
    fmt::format_to(out, "{:<11}{:>10}  not determined: {}\n", name, "-", describe(aligned.alignment.status));
  }
}

void add_row(Text out, std::string_view name, const std::optional<PoseErrorStatistics>& errors) {
  if (errors) {
    add_row(out, name, *errors);
  } else {
    fmt::format_to(out, "{:<11}{:>10}  not known: the path is too short\n", name, "-");
  }
}

void add_row(Text out, std::string_view name, const Consistency& c) {
  if (c.anees) {
    fmt::format_to(out, "{:<11}{:>10.4g}{:>10.4g}{:>10.4g}{:>11.1f} %{:>10}{:>10}\n", name, c.anees->pose,
                   c.anees->position, c.anees->attitude, 100.0 * c.share_within_95, c.frames,
                   c.frames_refused);
  } else {
    fmt::format_to(out, "{:<11}{:>10}  not known: no frame later than {:g} s with a usable covariance\n",
                   name, "-", kNeesSkip);
  }
}

void add_error_heading(Text out, std::string_view title, std::string_view first_column) {
  constexpr std::string_view kColumns = "      rmse      mean    median       std       max";
  fmt::format_to(out, "\n{}\n{:<11}{:>50}{:>50}\n", title, "", "position [m]", "attitude [deg]");
  fmt::format_to(out, "{:<11}{}{}\n", first_column, kColumns, kColumns);
}

void add_inputs(Text out, const EvaluationReport& report) {
  const TrajectoryEvaluation& e = report.evaluation;
  fmt::format_to(out, "estimate      {}\nground truth  {}\n", report.estimate, report.truth);
  fmt::format_to(out, "matched       {} of {} poses ", e.poses, report.estimated_poses);
  if (report.matched_by_time) {
    fmt::format_to(out, "in time (within {:g} ms), {:.1f} s\n", 1e3 * report.max_time_difference, e.duration);
  } else {
    fmt::format_to(out, "line by line\n");
  }
  fmt::format_to(out, "path length   {:.3f} m in truth, {:.3f} m in the estimate\n", e.path_length,
                 e.path_length_estimate);
}

void add_tilt(Text out, const EvaluationReport& report) {
  if (report.upright) {
    fmt::format_to(
        out,
        "tilt          {:.1f} deg between the verticals of both worlds, throughout: one of them is "
        "not level.\n"
        "              'none' and 'first pose' have that in them; 'upright' takes it out, then "
        "position and yaw\n"
        "              of the first pose\n",
        kToDegrees * report.tilt->angle);
  }
}

void add_over_distance(Text out, const std::vector<ErrorOverDistance>& errors) {
  if (errors.empty()) {
    return;
  }
  fmt::format_to(out, "\nRelative error over distance\n{:<11}{:>10}{:>40}{:>40}\n", "", "",
                 "position [% of the distance]", "attitude [deg]");
  fmt::format_to(out, "{:<11}{:>10}", "over", "pieces");
  for (int k = 0; k < 2; ++k) {
    fmt::format_to(out, "{:>10}{:>10}{:>10}{:>10}", "mean", "quartile", "median", "quartile");
  }
  fmt::format_to(out, "\n");
  for (const ErrorOverDistance& error : errors) {
    fmt::format_to(out, "{:<11}{:>10}", fmt::format("{:g} m", error.distance), error.pairs);
    for (const ErrorSpread& s : {error.position_percent, error.attitude_deg}) {
      fmt::format_to(out, "{:>10.4g}{:>10.4g}{:>10.4g}{:>10.4g}", s.mean, s.lower, s.median, s.upper);
    }
    fmt::format_to(out, "\n");
  }
}

Json spread_json(const ErrorSpread& spread) {
  return {{"mean", spread.mean},
          {"lower_quartile", spread.lower},
          {"median", spread.median},
          {"upper_quartile", spread.upper}};
}

Json over_distance_json(const std::vector<ErrorOverDistance>& errors) {
  Json out = Json::array();
  for (const ErrorOverDistance& error : errors) {
    out.push_back({{"distance_m", error.distance},
                   {"pieces", error.pairs},
                   {"position_percent", spread_json(error.position_percent)},
                   {"attitude_deg", spread_json(error.attitude_deg)}});
  }
  return out;
}

// Those with a covariance, which NEES needs.
std::vector<MatchedPose> with_covariance(const TrajectoryInput& estimate,
                                         const std::vector<MatchedPose>& matched) {
  std::vector<MatchedPose> known;
  for (const MatchedPose& pose : matched) {
    if (!estimate.covariances.empty() && !estimate.covariances[pose.index].hasNaN()) {
      known.push_back(pose);
    }
  }
  return known;
}

// How the worlds lie to each other, and what is left where they are askew.
void judge_tilt(const TrajectoryInput& estimate, const std::vector<MatchedPose>& matched,
                EvaluationReport& out) {
  const std::vector<MatchedPose> known = with_covariance(estimate, matched);
  out.tilt = known.empty() ? world_tilt(matched) : world_tilt(known, estimate.covariances);
  if (out.tilt && out.tilt->is_askew()) {
    const Alignment upright = align_upright(matched, *out.tilt);
    out.upright = {upright, absolute_errors(matched, upright)};
  }
}

std::optional<ConsistencyReport> consistency_of(const TrajectoryInput& estimate,
                                                const std::vector<MatchedPose>& matched,
                                                const std::optional<AlignedErrors>& upright) {
  if (estimate.covariances.empty()) {
    return std::nullopt;
  }
  const std::vector<MatchedPose> known = with_covariance(estimate, matched);
  const auto after = [&](const Alignment& alignment) {
    return average_nees(known, estimate.covariances, alignment, estimate.poses.front().t_ns);
  };
  ConsistencyReport out{after(align(matched, AlignmentKind::kNone)),
                        after(align(matched, AlignmentKind::kFirstPose)), std::nullopt};
  if (upright) {
    out.upright = after(upright->alignment);
  }
  return out;
}

}  // namespace

EvaluationReport evaluate(const TrajectoryInput& estimate, const TrajectoryInput& truth,
                          double max_time_difference, const RelativeErrorSettings& settings) {
  const Match matched = match(estimate, truth, max_time_difference);
  EvaluationReport report;
  report.estimate = estimate.path.string();
  report.truth = truth.path.string();
  report.estimated_poses = estimate.poses.size();
  report.matched_by_time = matched.by_time;
  report.max_time_difference = max_time_difference;
  report.settings = settings;
  report.evaluation = evaluate_trajectory(matched.poses, settings);
  judge_tilt(estimate, matched.poses, report);
  report.over_distance =
      errors_over_distances(matched.poses, round_distances(matched.poses), settings.relative_tolerance);
  report.consistency = consistency_of(estimate, matched.poses, report.upright);
  return report;
}

Json to_json(const Statistics& s) {
  return {{"rmse", s.rmse}, {"mean", s.mean}, {"median", s.median}, {"std", s.std},
          {"min", s.min},   {"max", s.max},   {"sse", s.sse},       {"count", s.count}};
}

Json ate_json(const TrajectoryEvaluation& evaluation) {
  return {{"none", rmse_json(evaluation.none)},
          {"se3", rmse_json(evaluation.se3)},
          {"sim3", rmse_json(evaluation.sim3)},
          {"scale", evaluation.sim3.errors ? Json(evaluation.sim3.alignment.scale) : Json(nullptr)}};
}

Json to_json(const Consistency& c) {
  return {{"pose", c.anees ? Json(c.anees->pose) : Json(nullptr)},
          {"position", c.anees ? Json(c.anees->position) : Json(nullptr)},
          {"attitude", c.anees ? Json(c.anees->attitude) : Json(nullptr)},
          {"share_within_95", c.anees ? Json(c.share_within_95) : Json(nullptr)},
          {"frames", c.frames},
          {"frames_refused", c.frames_refused}};
}

Json to_json(const EvaluationReport& report) {
  const TrajectoryEvaluation& e = report.evaluation;
  Json json = {{"estimate", report.estimate},
               {"groundtruth", report.truth},
               {"poses", report.estimated_poses},
               {"matched", e.poses},
               {"matched_by", report.matched_by_time ? "time" : "index"},
               {"duration_s", report.matched_by_time ? Json(e.duration) : Json(nullptr)},
               {"path_length_m", e.path_length},
               {"path_length_estimate_m", e.path_length_estimate},
               {"tilt_deg", report.tilt ? Json(kToDegrees * report.tilt->angle) : Json(nullptr)},
               {"ate_m", ate_json(e)}};
  json["ape"] = {{"none", errors_json(e.none)},
                 {"first_pose", errors_json(e.first_pose)},
                 {"upright", report.upright ? errors_json(*report.upright) : Json(nullptr)},
                 {"se3", errors_json(e.se3)},
                 {"sim3", errors_json(e.sim3)}};
  json["rpe"] = {{"1_frame", errors_json(e.relative_1_frame)},
                 {"distance", errors_json(e.relative_distance)},
                 {"over_distance", over_distance_json(report.over_distance)},
                 {"distance_m", report.settings.distance},
                 {"relative_tolerance", report.settings.relative_tolerance}};
  if (const auto& c = report.consistency) {
    json["anees"] = {{"none", to_json(c->none)},
                     {"first_pose", to_json(c->first_pose)},
                     {"upright", c->upright ? to_json(*c->upright) : Json(nullptr)}};
  } else {
    json["anees"] = nullptr;
  }
  return json;
}

std::string to_text(const EvaluationReport& report) {
  const TrajectoryEvaluation& e = report.evaluation;
  std::string text;
  const Text out = std::back_inserter(text);
  add_inputs(out, report);
  add_tilt(out, report);

  add_error_heading(out, "Absolute error", "alignment");
  add_row(out, "none", e.none);
  add_row(out, "first pose", e.first_pose);
  if (report.upright) {
    add_row(out, "upright", *report.upright);
  }
  add_row(out, "SE(3)", e.se3);
  add_row(out, "Sim(3)", e.sim3);
  if (e.sim3.errors) {
    fmt::format_to(out, "scale      {:>10.6g}  of Sim(3); multiplies the estimate\n", e.sim3.alignment.scale);
  }

  add_error_heading(out, "Relative error", "over");
  add_row(out, "1 frame", e.relative_1_frame);
  add_row(out, distance_name(report.settings), e.relative_distance);
  add_over_distance(out, report.over_distance);

  if (report.consistency) {
    fmt::format_to(out, "\nConsistency: average NEES per degree of freedom, 1 is consistent\n");
    fmt::format_to(out, "{:<11}{:>10}{:>10}{:>10}{:>13}{:>10}{:>10}\n", "alignment", "pose", "position",
                   "attitude", "within 95 %", "frames", "refused");
    add_row(out, "none", report.consistency->none);
    add_row(out, "first pose", report.consistency->first_pose);
    if (report.consistency->upright) {
      add_row(out, "upright", *report.consistency->upright);
    }
  }
  return text;
}

}  // namespace limber::app
