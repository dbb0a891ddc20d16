// SPDX-License-Identifier: MIT
#include "evaluation_report.hpp"

#include <fmt/format.h>

#include <iterator>
#include <string_view>

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

// NEES needs a covariance with every pose that enters.
std::optional<ConsistencyReport> consistency_of(const TrajectoryInput& estimate,
                                                const std::vector<MatchedPose>& matched) {
  if (estimate.covariances.empty()) {
    return std::nullopt;
  }
  std::vector<MatchedPose> known;
  for (const MatchedPose& pose : matched) {
    if (!estimate.covariances[pose.index].hasNaN()) {
      known.push_back(pose);
    }
  }
  const std::int64_t start_ns = estimate.poses.front().t_ns;
  return ConsistencyReport{
      average_nees(known, estimate.covariances, align(matched, AlignmentKind::kNone), start_ns),
      average_nees(known, estimate.covariances, align(matched, AlignmentKind::kFirstPose), start_ns)};
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
  report.consistency = consistency_of(estimate, matched.poses);
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
               {"ate_m", ate_json(e)}};
  json["ape"] = {{"none", errors_json(e.none)},
                 {"first_pose", errors_json(e.first_pose)},
                 {"se3", errors_json(e.se3)},
                 {"sim3", errors_json(e.sim3)}};
  json["rpe"] = {{"1_frame", errors_json(e.relative_1_frame)},
                 {"distance", errors_json(e.relative_distance)},
                 {"distance_m", report.settings.distance},
                 {"relative_tolerance", report.settings.relative_tolerance}};
  json["anees"] = report.consistency ? Json{{"none", to_json(report.consistency->none)},
                                            {"first_pose", to_json(report.consistency->first_pose)}}
                                     : Json(nullptr);
  return json;
}

std::string to_text(const EvaluationReport& report) {
  const TrajectoryEvaluation& e = report.evaluation;
  std::string text;
  const Text out = std::back_inserter(text);
  add_inputs(out, report);

  add_error_heading(out, "Absolute error", "alignment");
  add_row(out, "none", e.none);
  add_row(out, "first pose", e.first_pose);
  add_row(out, "SE(3)", e.se3);
  add_row(out, "Sim(3)", e.sim3);
  if (e.sim3.errors) {
    fmt::format_to(out, "scale      {:>10.6g}  of Sim(3); multiplies the estimate\n", e.sim3.alignment.scale);
  }

  add_error_heading(out, "Relative error", "over");
  add_row(out, "1 frame", e.relative_1_frame);
  add_row(out, distance_name(report.settings), e.relative_distance);

  if (report.consistency) {
    fmt::format_to(out, "\nConsistency: average NEES per degree of freedom, 1 is consistent\n");
    fmt::format_to(out, "{:<11}{:>10}{:>10}{:>10}{:>13}{:>10}{:>10}\n", "alignment", "pose", "position",
                   "attitude", "within 95 %", "frames", "refused");
    add_row(out, "none", report.consistency->none);
    add_row(out, "first pose", report.consistency->first_pose);
  }
  return text;
}

}  // namespace limber::app
