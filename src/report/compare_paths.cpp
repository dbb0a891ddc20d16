// SPDX-License-Identifier: MIT
#include "compare/same_recording.hpp"
#include "compare_sections.hpp"
#include "limber/evaluate/alignment.hpp"

namespace limber::detail {
namespace {

void append(const Eigen::Vector3d& p, ReportTrace& trace) {
  trace.x.push_back(p.x());
  trace.y.push_back(p.y());
}

/// From the world of a run's truth to that of the group's first one: the same pose at the same time.
Pose between_truths(const RunFolder& first, const RunFolder& run) {
  for (auto at = run.matched.begin(); const MatchedPose& pose : first.matched) {
    while (at != run.matched.end() && at->t_ns < pose.t_ns) {
      ++at;
    }
    if (at != run.matched.end() && at->t_ns == pose.t_ns) {
      return pose.truth * at->truth.inverse();
    }
  }
  return {};
}

std::vector<MatchedPose> against_first(const RunGroup& group, std::size_t run) {
  std::vector<MatchedPose> both;
  const RunFolder &own = *group.runs[run].run, &first = group.first();
  for (const auto& [n, m] : common_frames(own, first)) {
    both.push_back(
        {own.trajectory[n].t_ns, n, own.trajectory[n].T_world_body, first.trajectory[m].T_world_body});
  }
  return both;
}

}  // namespace

Pose drawn_alignment(const RunGroup& group, std::size_t run) {
  if (!group.has_truth()) {
    return align(against_first(group, run), AlignmentKind::kFirstPose).T_true_est;
  }
  const RunFolder& own = *group.runs[run].run;
  return between_truths(group.first(), own) * align(own.matched, AlignmentKind::kSe3).T_true_est;
}

ReportSection paths_section(const RunGroup& group) {
  ReportFigure figure;
  figure.id = "path" + group.id;
  figure.title = "Path from above";
  figure.kind = FigureKind::kTopView;
  figure.x = {"x", "m"};
  figure.y = {{"y", "m"}};
  figure.caption = group.has_truth()
                       ? "Each run after a rigid fit of all its positions to the truth."
                       : "No truth is known: position and yaw of the first poses are put together.";
  if (group.has_truth()) {
    ReportTrace& truth = figure.traces.emplace_back();
    truth = {"truth", "truth", TraceShape::kLine, {}, {}, {}, 0};
    for (const MatchedPose& pose : group.first().matched) {
      append(pose.truth.p, truth);
      truth.t.push_back(group.runs.front().seconds(pose.t_ns));
    }
  }
  for (std::size_t k = 0; k < group.runs.size(); ++k) {
    const DrawnRun& drawn = group.runs[k];
    const Pose alignment = drawn_alignment(group, k);
    ReportTrace& path = figure.traces.emplace_back();
    path = {drawn.name, drawn.style, TraceShape::kLine, {}, {}, {}, 0};
    for (const TrajectoryRow& row : drawn.run->trajectory) {
      append(alignment * row.T_world_body.p, path);
      path.t.push_back(drawn.seconds(row.t_ns));
    }
  }
  return {"trajectory", "Trajectory", {std::move(figure)}};
}

}  // namespace limber::detail
