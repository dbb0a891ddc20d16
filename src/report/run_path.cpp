// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "limber/evaluate/alignment.hpp"
#include "run_sections.hpp"

namespace limber::detail {
namespace {

constexpr const char* kLandmarks = "landmarks";  // a style

void append(const Eigen::Vector3d& p, ReportTrace& trace, bool in_space) {
  trace.x.push_back(p.x());
  trace.y.push_back(p.y());
  if (in_space) {
    trace.z.push_back(p.z());
  }
}

/// `matched`: poses with the truth as it is to be drawn.
ReportFigure path_figure(const RunFolder& run, const std::vector<MatchedPose>& matched, bool in_space) {
  ReportFigure figure;
  figure.id = in_space ? "path-3d" : "path";
  figure.title = in_space ? "Path and map in space" : "Path from above";
  figure.kind = in_space ? FigureKind::kSpace : FigureKind::kTopView;
  figure.x = {"x", "m"};
  figure.y = {{"y", "m"}};
  if (in_space) {
    figure.y.push_back({"z", "m"});
    figure.caption = "Drag to turn, scroll to come closer.";
  }
  if (in_space) {  // seen from above, the map would hide the path
    figure.variants = {{"path and map", {}}, {"path alone", {kLandmarks}}};
    ReportTrace& landmarks = figure.traces.emplace_back();
    landmarks = {"landmarks at the end", kLandmarks, TraceShape::kDots, {}, {}, {}, 0};
    for (const auto& [id, p_world_landmark] : run.landmarks) {
      append(p_world_landmark, landmarks, in_space);
    }
  }
  if (!matched.empty()) {
    ReportTrace& truth = figure.traces.emplace_back();
    truth = {"truth", "truth", TraceShape::kLine, {}, {}, {}, 0};
    for (const MatchedPose& pose : matched) {
      append(pose.truth.p, truth, in_space);
      truth.t.push_back(run.seconds(pose.t_ns));
    }
  }
  ReportTrace& estimate = figure.traces.emplace_back();
  estimate = {run.method, run.method, TraceShape::kLine, {}, {}, {}, 0};
  for (const TrajectoryRow& row : run.trajectory) {
    append(row.T_world_body.p, estimate, in_space);
    estimate.t.push_back(run.seconds(row.t_ns));
  }
  return figure;
}

double rms_distance(const std::vector<MatchedPose>& poses) {
  double squares = 0.0;
  for (const MatchedPose& pose : poses) {
    squares += (pose.truth.p - pose.estimate.p).squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(poses.size()));
}

/// The truth moved so that it fits the whole estimate best; as it is where that is not determined.
std::vector<MatchedPose> fitted(std::vector<MatchedPose> poses) {
  const Alignment fit = align(poses, AlignmentKind::kSe3);
  if (fit.status == AlignmentStatus::kAligned) {
    for (MatchedPose& pose : poses) {
      pose.truth = fit.T_true_est.inverse() * pose.truth;
    }
  }
  return poses;
}

/// How truth and estimate were brought together, for the errors and for the figures of this section.
std::string alignment_in_words(const RunFolder& run, const std::vector<MatchedPose>& drawn) {
  const std::string alignment = in_words(run.summary.value("alignment", Json("nothing")));
  if (alignment == "nothing") {
    return "Truth and estimate are as they are, without any alignment.";
  }
  return fmt::format(
      "Drawn here after a rigid fit of all positions, which leaves {:.3g} m. Errors further below are "
      "aligned by "
      "the {}, which leaves {:.3g} m.",
      rms_distance(drawn), alignment, rms_distance(run.matched));
}

}  // namespace

ReportSection path_section(const RunFolder& run) {
  ReportSection section{"trajectory", "Trajectory", {}};
  std::vector<MatchedPose> drawn = run.matched;
  if (!run.matched.empty()) {
    if (run.summary.value("alignment", Json("nothing")) != "nothing") {
      drawn = fitted(std::move(drawn));
    }
    section.blocks.emplace_back(ReportText{alignment_in_words(run, drawn)});
  }
  section.blocks.emplace_back(path_figure(run, drawn, false));
  section.blocks.emplace_back(path_figure(run, drawn, true));
  return section;
}

}  // namespace limber::detail
