// SPDX-License-Identifier: MIT
#include "run_sections.hpp"

namespace limber::detail {
namespace {

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
  figure.title = in_space ? "Path and map in space" : "Path and map from above";
  figure.kind = in_space ? FigureKind::kSpace : FigureKind::kTopView;
  figure.x = {"x", "m"};
  figure.y = {{"y", "m"}};
  if (in_space) {
    figure.y.push_back({"z", "m"});
    figure.caption = "Drag to turn, scroll to come closer.";
  }
  ReportTrace landmarks{"landmarks at the end", "landmarks", TraceShape::kDots, {}, {}, {}, 0};
  for (const auto& [id, p_world_landmark] : run.landmarks) {
    append(p_world_landmark, landmarks, in_space);
  }
  ReportTrace truth{"truth", "truth", TraceShape::kLine, {}, {}, {}, 0};
  for (const MatchedPose& pose : run.matched) {
    append(pose.truth.p, truth, in_space);
  }
  ReportTrace estimate{run.method, run.method, TraceShape::kLine, {}, {}, {}, 0};
  for (const TrajectoryRow& row : run.trajectory) {
    append(row.T_world_body.p, estimate, in_space);
  }
  figure.traces.push_back(std::move(landmarks));
  if (!run.matched.empty()) {
    figure.traces.push_back(std::move(truth));
  }
  figure.traces.push_back(std::move(estimate));
  return figure;
}

}  // namespace

ReportSection path_section(const RunFolder& run) {
  ReportSection section{"trajectory", "Trajectory", {}};
  if (!run.matched.empty()) {
    section.blocks.emplace_back(
        ReportText{"The truth is drawn in the world of the estimate. Taken out before errors are counted: " +
                   in_words(run.summary.value("alignment", Json(nullptr))) + "."});
  }
  section.blocks.emplace_back(path_figure(run, false));
  section.blocks.emplace_back(path_figure(run, true));
  return section;
}

}  // namespace limber::detail
