// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <cmath>

#include "compare/same_recording.hpp"
#include "compare_sections.hpp"
#include "limber/core/angle.hpp"
#include "limber/evaluate/alignment.hpp"
#include "limber/evaluate/trajectory_error.hpp"

namespace limber::detail {
namespace {

/// Length of position and attitude error over time, each with its bound.
struct ErrorFigures {
  ReportFigure position, attitude;
};

void append(double t, double value, ReportTrace& trace) {
  trace.x.push_back(t);
  trace.y.push_back(value);
}

void draw_errors(const DrawnRun& drawn, const std::vector<MatchedPose>& poses, const Pose& alignment,
                 ErrorFigures& out) {
  ReportTrace position{drawn.name, drawn.style, TraceShape::kLine, {}, {}, {}, 0}, attitude = position;
  for (const MatchedPose& pose : poses) {
    const PoseErrorVector error = pose_error(alignment * pose.estimate, pose.truth);
    append(drawn.seconds(pose.t_ns), error.head<3>().norm(), position);
    append(drawn.seconds(pose.t_ns), kToDegrees * error.tail<3>().norm(), attitude);
  }
  out.position.traces.push_back(std::move(position));
  out.attitude.traces.push_back(std::move(attitude));
}

void draw_bounds(const DrawnRun& drawn, ErrorFigures& out) {
  ReportTrace position{"3 sigma", drawn.style, TraceShape::kBound, {}, {}, {}, 0}, attitude = position;
  for (const TrajectoryRow& row : drawn.run->trajectory) {
    if (row.covariance) {
      const auto variances = row.covariance->diagonal();
      append(drawn.seconds(row.t_ns), 3.0 * std::sqrt(variances.head<3>().sum()), position);
      append(drawn.seconds(row.t_ns), 3.0 * kToDegrees * std::sqrt(variances.tail<3>().sum()), attitude);
    }
  }
  out.position.traces.push_back(std::move(position));
  out.attitude.traces.push_back(std::move(attitude));
}

ErrorFigures errors_against_truth(const RunGroup& group) {
  const std::string caption = fmt::format(
      "Length of the error, aligned as in each run's summary.json{}; dotted: three standard "
      "deviations, root of the summed variances.",
      group.tilted() ? " (the world of the truth is not level: that tilt is taken out)" : "");
  ErrorFigures out{
      figure_over_time("position-error" + group.id, "Position error", {{"error", "m"}}, caption),
      figure_over_time("attitude-error" + group.id, "Attitude error", {{"error", "deg"}}, caption)};
  for (const DrawnRun& drawn : group.runs) {
    draw_errors(drawn, drawn.run->matched, {}, out);
    draw_bounds(drawn, out);
  }
  return out;
}

/// Without truth: how far each run is from the first one.
ErrorFigures distances(const RunGroup& group) {
  const std::string caption =
      fmt::format("No truth is known: distance from {}, position and yaw of the first poses put together.",
                  group.runs[0].name);
  ErrorFigures out{
      figure_over_time("position-error" + group.id, "Distance between runs", {{"distance", "m"}}, caption),
      figure_over_time("attitude-error" + group.id, "Angle between runs", {{"angle", "deg"}}, caption)};
  for (std::size_t k = 1; k < group.runs.size(); ++k) {
    const RunFolder &own = *group.runs[k].run, &first = group.first();
    std::vector<MatchedPose> both;
    for (const auto& [n, m] : common_frames(own, first)) {
      both.push_back(
          {own.trajectory[n].t_ns, n, own.trajectory[n].T_world_body, first.trajectory[m].T_world_body});
    }
    draw_errors(group.runs[k], both, drawn_alignment(group, k), out);
  }
  return out;
}

ReportFigure relative_figure(const RunGroup& group) {
  const double piece_m = group.compared.front()->piece_m;
  ReportFigure figure = figure_over_time(
      "relative-error" + group.id, "Relative error, piece by piece", {{"position", "%"}, {"attitude", "deg"}},
      fmt::format("Of disjoint pieces of {:g} m of the path, at the end of each: what the table's "
                  "differences are made of. No alignment enters.",
                  piece_m));
  for (const DrawnRun& drawn : group.runs) {
    const std::vector<IndexPair> pieces = disjoint_pieces(drawn.run->matched, piece_m);
    const std::vector<RelativeError> errors = relative_errors_of(drawn.run->matched, pieces);
    ReportTrace position{drawn.name, drawn.style, TraceShape::kLine, {}, {}, {}, 0}, attitude = position;
    attitude.panel = 1;
    for (std::size_t k = 0; k < pieces.size(); ++k) {
      const double t = drawn.seconds(drawn.run->matched[pieces[k].second].t_ns);
      append(t, 100.0 * errors[k].position_m / piece_m, position);
      append(t, errors[k].attitude_deg, attitude);
    }
    figure.traces.push_back(std::move(position));
    figure.traces.push_back(std::move(attitude));
  }
  return figure;
}

}  // namespace

ReportSection errors_section(const RunGroup& group) {
  const bool judged = group.has_truth();
  ReportSection section{"errors", judged ? "Errors" : "Distance", {}};
  if (!judged && group.runs.size() < 2) {
    return section;
  }
  ErrorFigures figures = judged ? errors_against_truth(group) : distances(group);
  section.blocks.emplace_back(std::move(figures.position));
  section.blocks.emplace_back(std::move(figures.attitude));
  if (judged) {
    section.blocks.emplace_back(relative_figure(group));
    ReportFigure over_distance = distance_figure(group.runs, group.id);
    if (!over_distance.traces.empty()) {
      section.blocks.emplace_back(std::move(over_distance));
    }
  }
  return section;
}

ReportSection states_section(const RunGroup& group) {
  ReportSection section{"motion", "Velocity and biases", {}};
  for (ReportFigure& figure : motion_figures(group.runs, group.id)) {
    section.blocks.emplace_back(std::move(figure));
  }
  return section;
}

ReportSection calibrations_section(const RunGroup& group) {
  ReportSection section{"calibration", "Calibration", {}};
  std::vector<DrawnRun> watched;
  for (const DrawnRun& drawn : group.runs) {
    if (!drawn.run->health.empty()) {
      watched.push_back(drawn);
    }
  }
  std::vector<ReportFigure> figures = estimated_figures(group.runs, group.id);
  if (!watched.empty()) {
    const std::vector<ReportFigure> offsets = offset_figures(watched, group.id);
    figures.insert(figures.end(), offsets.begin(), offsets.end());
  }
  for (ReportFigure& figure : figures) {
    section.blocks.emplace_back(std::move(figure));
  }
  return section;
}

}  // namespace limber::detail
