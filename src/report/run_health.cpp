// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "limber/diagnose/health_summary.hpp"
#include "run_sections.hpp"

namespace limber::detail {
namespace {

constexpr double kSmallestDrawn = 1e-30;  // p-value; curves are 32-bit floats
constexpr std::size_t kMostStretches = 25;
constexpr const char* kOffsetStyle = "series 1";
constexpr const char* kAlarmStyle = "series 2";

TableCell::Mark mark_of(HealthVerdict verdict) {
  switch (verdict) {
    case HealthVerdict::kOk:
      return TableCell::Mark::kBest;
    case HealthVerdict::kDecalibrated:
      return TableCell::Mark::kBad;
    case HealthVerdict::kSuspect:
    case HealthVerdict::kCannotTell:
      break;
  }
  return TableCell::Mark::kNone;
}

TableCell cell_of(HealthVerdict verdict) { return {to_string(verdict), mark_of(verdict)}; }

void append(double t, double value, ReportTrace& trace) {
  trace.x.push_back(t);
  trace.y.push_back(value);
}

/// Three axes of theta from `first` on, window by window.
ReportFigure offset_figure(const RunFolder& run, const std::vector<HealthReport>& windows, std::size_t first,
                           ReportFigure figure) {
  for (std::size_t panel = 0; panel < 3; ++panel) {
    const std::size_t axis = first + panel;
    const auto k = static_cast<Eigen::Index>(axis);
    ReportTrace delta{"offset", kOffsetStyle, TraceShape::kLine, {}, {}, {}, panel};
    ReportTrace upper{"+3 sigma", kOffsetStyle, TraceShape::kBound, {}, {}, {}, panel};
    ReportTrace lower{"-3 sigma", kOffsetStyle, TraceShape::kBound, {}, {}, {}, panel};
    ReportTrace alarm{"alarm", kAlarmStyle, TraceShape::kDots, {}, {}, {}, panel};
    for (const HealthReport& window : windows) {
      const double t = run.seconds(window.t_ns);
      const bool known = window.axes[axis] != HealthVerdict::kCannotTell;
      const double value = known ? in_degrees_and_mm(window.gathered_delta)(k) : kNan;
      const double bound = known ? 3.0 * in_degrees_and_mm(window.gathered_sigma)(k) : kNan;
      append(t, value, delta);
      append(t, bound, upper);
      append(t, -bound, lower);
      append(t, window.alarm ? value : kNan, alarm);
    }
    figure.traces.push_back(std::move(delta));
    figure.traces.push_back(std::move(upper));
    figure.traces.push_back(std::move(lower));
    if (std::any_of(windows.begin(), windows.end(), [](const HealthReport& w) { return w.alarm; })) {
      figure.traces.push_back(std::move(alarm));
    }
  }
  return figure;
}

ReportFigure p_value_figure(const RunFolder& run) {
  ReportFigure figure = figure_over_time(
      "health-p-value", "p-value of the calibration", {{"p-value", ""}},
      "Chance that a sound rig looks like that: of each frame alone, and of what was gathered in its window. "
      "Values below 1e-30 are drawn there.");
  figure.log_switch = true;
  figure.starts_in_log = true;
  ReportTrace frame{"frame", "band", TraceShape::kDots, {}, {}, {}, 0};
  ReportTrace gathered{"gathered", kOffsetStyle, TraceShape::kLine, {}, {}, {}, 0};
  ReportTrace alarm{"alarm", kAlarmStyle, TraceShape::kDots, {}, {}, {}, 0};
  for (const HealthReport& report : run.health) {
    const double t = run.seconds(report.t_ns);
    append(t, std::max(report.p_value, kSmallestDrawn), frame);
    append(t, std::max(report.gathered_p_value, kSmallestDrawn), gathered);
    if (report.alarm) {
      append(t, std::max(std::min(report.p_value, report.gathered_p_value), kSmallestDrawn), alarm);
    }
  }
  figure.traces = {std::move(frame), std::move(gathered)};
  if (!alarm.x.empty()) {
    figure.traces.push_back(std::move(alarm));
  }
  return figure;
}

/// The whole run, axis by axis.
ReportTable axis_table(const HealthSummary& summary) {
  ReportTable table{"The rig over the whole recording",
                    {"axis", "true - assumed", "standard deviation", "unit", "verdict"},
                    {},
                    "cam1 against cam0: mean of the windows, weighted by their information; the standard "
                    "deviation is that of one window, because windows share the errors of pose and map."};
  const RigParameters delta = in_degrees_and_mm(summary.mean.delta);
  const RigParameters sigma = in_degrees_and_mm(summary.mean.sigma);
  for (std::size_t axis = 0; axis < 6; ++axis) {
    const auto k = static_cast<Eigen::Index>(axis);
    table.rows.push_back({{std::string(kParameterNames[axis])},
                          {fmt::format("{:+.4f}", delta(k))},
                          {fmt::format("{:.4f}", sigma(k))},
                          {axis < 3 ? "deg" : "mm"},
                          cell_of(summary.axes[axis])});
  }
  return table;
}

/// Frames in a row with the same verdict.
ReportTable stretch_table(const RunFolder& run) {
  ReportTable table{"When", {"from", "to", "verdict", "axes that moved"}, {}, ""};
  std::size_t stretches = 0;
  for (std::size_t begin = 0, end = 0; begin < run.health.size(); begin = end) {
    std::array<bool, 6> named{};
    const HealthVerdict verdict = run.health[begin].verdict;
    for (end = begin; end < run.health.size() && run.health[end].verdict == verdict; ++end) {
      for (std::size_t k = 0; k < 6; ++k) {
        named[k] |= run.health[end].axes[k] == HealthVerdict::kDecalibrated;
      }
    }
    std::string axes;
    for (std::size_t k = 0; k < 6; ++k) {
      axes += named[k] ? (axes.empty() ? "" : ", ") + std::string(kParameterNames[k]) : "";
    }
    if (++stretches <= kMostStretches) {
      table.rows.push_back({{fmt::format("{:.2f} s", run.seconds(run.health[begin].t_ns))},
                            {fmt::format("{:.2f} s", run.seconds(run.health[end - 1].t_ns))},
                            cell_of(verdict),
                            {axes.empty() ? "–" : axes}});
    }
  }
  if (stretches > kMostStretches) {
    table.note = fmt::format("The first {} of {} stretches; all of them are in health.csv.", kMostStretches,
                             stretches);
  }
  return table;
}

/// The reduction of health.csv, as in summary.json.
HealthSummary summary_of(const RunFolder& run) {
  std::vector<FrameReport> frames(run.health.size());
  for (std::size_t k = 0; k < frames.size(); ++k) {
    frames[k].t_ns = run.health[k].t_ns;
    frames[k].health = run.health[k];
  }
  return *summarize_health(frames);
}

}  // namespace

ReportSection calibration_section(const RunFolder& run) {
  const std::vector<HealthReport> windows = windows_of(run.health);
  const HealthSummary summary = summary_of(run);
  const std::string caption =
      "True minus assumed calibration, as gathered in each window; dotted: three standard deviations about "
      "zero, within which a sound rig stays. A gap: this axis could not be told.";
  ReportSection section{"calibration", "Calibration", {}};
  section.blocks.emplace_back(ReportText{fmt::format("Verdict: {}.", to_string(summary.verdict))});
  section.blocks.emplace_back(axis_table(summary));
  section.blocks.emplace_back(
      offset_figure(run, windows, 0,
                    figure_over_time("health-rotation", "Offset of the rig: rotation",
                                     {{"ax", "deg"}, {"ay", "deg"}, {"az", "deg"}}, caption)));
  section.blocks.emplace_back(
      offset_figure(run, windows, 3,
                    figure_over_time("health-translation", "Offset of the rig: translation",
                                     {{"tx", "mm"}, {"ty", "mm"}, {"tz", "mm"}}, caption)));
  section.blocks.emplace_back(p_value_figure(run));
  section.blocks.emplace_back(stretch_table(run));
  return section;
}

}  // namespace limber::detail
