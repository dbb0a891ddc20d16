// SPDX-License-Identifier: MIT
#include <utility>

#include "run_sections.hpp"

namespace limber::detail {
namespace {

ReportTrace trace_of(const RunFolder& run, const char* name, const char* style,
                     double (*value)(const FrameRow&)) {
  ReportTrace trace{name, style, TraceShape::kLine, {}, {}, {}, 0};
  for (const FrameRow& frame : run.frames) {
    trace.x.push_back(run.seconds(frame.t_ns));
    trace.y.push_back(value(frame));
  }
  return trace;
}

template <std::size_t FrameRow::*member>
double count_of(const FrameRow& frame) {
  return static_cast<double>(frame.*member);
}

}  // namespace

ReportFigure figure_over_time(std::string id, std::string title, std::vector<ReportAxis> y,
                              std::string caption) {
  ReportFigure figure;
  figure.id = std::move(id);
  figure.title = std::move(title);
  figure.caption = std::move(caption);
  figure.x = {"time", "s"};
  figure.y = std::move(y);
  return figure;
}

ReportSection point_section(const RunFolder& run) {
  ReportFigure figure =
      figure_over_time("points-per-frame", "Points per frame", {{"points", ""}},
                       "Observed: seen by the left camera or both. Used: entered the update. "
                       "Initialized: new in the map. Refused: by the gate, or not projectable.");
  figure.traces = {trace_of(run, "observed", "wide", count_of<&FrameRow::observed>),
                   trace_of(run, "used", "series 1", count_of<&FrameRow::used>),
                   trace_of(run, "initialized", "series 3", count_of<&FrameRow::initialized>),
                   trace_of(run, "refused", "series 2", count_of<&FrameRow::refused>)};
  return {"points", "Points", {std::move(figure)}};
}

ReportSection time_section(const RunFolder& run) {
  ReportFigure figure =
      figure_over_time("time-per-frame", "Time spent on each frame", {{"time spent", "ms"}},
                       "Front end: reading and tracking images, or taking matched points as "
                       "they are.");
  figure.log_switch = true;
  figure.traces = {trace_of(run, "filter", "series 1", [](const FrameRow& f) { return f.filter_ms; }),
                   trace_of(run, "front end", "series 3", [](const FrameRow& f) { return f.source_ms; })};
  return {"time", "Time", {std::move(figure)}};
}

}  // namespace limber::detail
