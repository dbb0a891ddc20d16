// SPDX-License-Identifier: MIT
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

ReportFigure path_figure(const RunFolder& run, bool in_space) {
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
  if (!run.matched.empty()) {
    ReportTrace& truth = figure.traces.emplace_back();
    truth = {"truth", "truth", TraceShape::kLine, {}, {}, {}, 0};
    for (const MatchedPose& pose : run.matched) {
      append(pose.truth.p, truth, in_space);
    }
  }
  ReportTrace& estimate = figure.traces.emplace_back();
  estimate = {run.method, run.method, TraceShape::kLine, {}, {}, {}, 0};
  for (const TrajectoryRow& row : run.trajectory) {
    append(row.T_world_body.p, estimate, in_space);
  }
  return figure;
}

}  // namespace

ReportSection path_section(const RunFolder& run) {
  ReportSection section{"trajectory", "Trajectory", {}};
  if (!run.matched.empty()) {
    const std::string alignment = in_words(run.summary.value("alignment", Json("nothing")));
    section.blocks.emplace_back(
        ReportText{"Errors are truth minus estimate, " +
                   (alignment == "nothing" ? "without any alignment" : "aligned by the " + alignment) +
                   ". The truth is drawn in the world of the estimate."});
  }
  section.blocks.emplace_back(path_figure(run, false));
  section.blocks.emplace_back(path_figure(run, true));
  return section;
}

}  // namespace limber::detail
