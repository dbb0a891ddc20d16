// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <utility>

#include "run_sections.hpp"

namespace limber::detail {
namespace {

constexpr double kBandProbability = 0.95;

/// The two-sided band of chi-square(dof) / dof.
Interval band(std::size_t dof) {
  return normalized_mean_interval(static_cast<double>(dof), 1, kBandProbability);
}

ReportTable nis_table(const RunFolder& run) {
  std::vector<NisSample> samples;
  std::size_t inside = 0;
  for (const FrameRow& frame : run.frames) {
    if (frame.dof > 0) {
      samples.push_back({frame.nis, static_cast<double>(frame.dof)});
      const double per_dof = frame.nis / static_cast<double>(frame.dof);
      inside += per_dof >= band(frame.dof).lower && per_dof <= band(frame.dof).upper ? 1 : 0;
    }
  }
  ReportTable table{"All innovations together", {"", "measured", "expected"}, {}, ""};
  if (const auto average = average_nis(samples)) {
    table.rows = {
        {{"NIS per degree of freedom"},
         {fmt::format("{:.4f}", average->per_dof)},
         {fmt::format("{:.4f} to {:.4f}", average->interval.lower, average->interval.upper)}},
        {{"frames within their band"},
         {fmt::format("{:.1f} %", 100.0 * static_cast<double>(inside) / static_cast<double>(samples.size()))},
         {fmt::format("{:.0f} %", 100.0 * kBandProbability)}}};
    table.note = fmt::format(
        "{} frames, {:.0f} degrees of freedom in all; expected: the two-sided 95 % range of a consistent "
        "filter.",
        average->updates, average->dof);
  } else {
    table.note = "No frame brought a measurement.";
  }
  return table;
}

}  // namespace

ReportSection innovation_section(const RunFolder& run) {
  ReportFigure figure = figure_over_time(
      "nis", "Normalised innovation squared, per degree of freedom", {{"NIS / d.o.f.", ""}},
      "Of the rows that entered each update (with a constraint: the projected ones). The band holds 95 % of "
      "the frames of a consistent filter; it is wider where a frame has fewer rows.");
  figure.log_switch = true;
  ReportTrace nis{"NIS / d.o.f.", run.method, TraceShape::kDots, {}, {}, {}, 0};
  ReportTrace lower{"95 % band", "band", TraceShape::kLine, {}, {}, {}, 0}, upper = lower;
  for (const FrameRow& frame : run.frames) {
    const bool measured = frame.dof > 0;
    const Interval range = measured ? band(frame.dof) : Interval{kNan, kNan};
    const double t = run.seconds(frame.t_ns);
    for (const auto& [trace, value] :
         {std::pair<ReportTrace*, double>{&nis, measured ? frame.nis / static_cast<double>(frame.dof) : kNan},
          {&lower, range.lower},
          {&upper, range.upper}}) {
      trace->x.push_back(t);
      trace->y.push_back(value);
    }
  }
  figure.traces = {std::move(nis), std::move(upper), std::move(lower)};
  return {"innovations", "Innovations", {std::move(figure), nis_table(run)}};
}

}  // namespace limber::detail
