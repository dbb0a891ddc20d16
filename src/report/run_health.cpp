// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <array>
#include <utility>

#include "limber/diagnose/health_summary.hpp"
#include "run_sections.hpp"

namespace limber::detail {
namespace {

constexpr double k95 = 1.96;
constexpr const char* kSizeStyle = "series 1";
constexpr const char* kChangeStyle = "series 2";
constexpr const char* kOkStyle = "series 3";
constexpr const char* kWrongStyle = "series 4";

TableCell cell_of(const std::string& verdict) {
  if (verdict == to_string(HealthVerdict::kOk)) {
    return {verdict, TableCell::Mark::kBest};
  }
  const bool wrong = verdict == to_string(HealthVerdict::kDecalibrated);
  return {verdict, wrong ? TableCell::Mark::kBad : TableCell::Mark::kNone};
}

/// A number of summary.json as text.
std::string number(const Json& json, const char* name, const char* format) {
  return json.contains(name) && json[name].is_number()
             ? fmt::format(fmt::runtime(format), json[name].get<double>())
             : "–";
}

void append(double t, double value, ReportTrace& trace) {
  trace.x.push_back(t);
  trace.y.push_back(value);
}

/// Size against tolerance, as summary.json has it.
ReportTable tolerance_table(const Json& state) {
  ReportTable table{"Size against tolerance",
                    {"", "size", "95 % from", "to", "ok up to", "wrong from", "unit", "verdict"},
                    {},
                    "Off the epipolar line: root mean square over the points seen."};
  const auto add = [&](const std::string& name, const Json& effect, const char* unit) {
    table.rows.push_back({{name},
                          {number(effect, "size", "{:.2f}")},
                          {number(effect, "low", "{:.2f}")},
                          {number(effect, "high", "{:.2f}")},
                          {number(effect, "ok", "{:g}")},
                          {number(effect, "wrong", "{:g}")},
                          {unit},
                          cell_of(effect.value("verdict", ""))});
  };
  add("off the epipolar line", state.at("epipolar_px"), "px");
  if (state.contains("movement_px")) {
    add("moves from frame to frame", state.at("movement_px"), "px");
  }
  if (state.contains("movement_depth_percent")) {
    add("and so do depths", state.at("movement_depth_percent"), "%");
  }
  add(fmt::format("depth at {} baselines", number(state.at("depth_percent"), "baselines", "{:g}")),
      state.at("depth_percent"), "%");
  return table;
}

ReportTable axis_table(const Json& state) {
  ReportTable table{
      "cam1 against cam0, axis by axis",
      {"axis", "", "true - assumed", "standard deviation", "ok up to", "wrong from", "unit", "verdict"},
      {},
      "Where the effect of an axis alone reaches the tolerance."};
  for (std::size_t k = 0; k < 6; ++k) {
    const Json& axis = state.at("axes").at(std::string(kParameterNames[k]));
    table.rows.push_back({{std::string(kParameterNames[k])},
                          {axis.value("words", "")},
                          {number(axis, "error", "{:+.4f}")},
                          {number(axis, "sigma", "{:.4f}")},
                          {number(axis, "ok", "{:.3f}")},
                          {number(axis, "wrong", "{:.3f}")},
                          {axis.value("unit", "")},
                          cell_of(axis.value("verdict", ""))});
  }
  return table;
}

ReportTable stretch_table(const Json& health) {
  ReportTable table{"When", {"from", "to", "verdict", "off the line [px]", "depth [%]"}, {}, ""};
  const auto add = [&](const Json& state) {
    table.rows.push_back({{number(state, "from_s", "{:.1f} s")},
                          {number(state, "to_s", "{:.1f} s")},
                          cell_of(state.value("verdict", "")),
                          {number(state.at("epipolar_px"), "size", "{:.2f}")},
                          {number(state.at("depth_percent"), "size", "{:.2f}")}});
  };
  for (const Json& state : health.at("past")) {
    add(state);
  }
  add(health.at("present"));
  return table;
}

void add_bands(const RunFolder& run, const Json& effect, std::size_t panel, ReportFigure& figure) {
  const double from = run.seconds(run.health.front().window_from_ns),
               to = run.seconds(run.health.back().t_ns);
  for (const auto& [name, style] : {std::pair{"ok", kOkStyle}, std::pair{"wrong", kWrongStyle}}) {
    if (effect.contains(name)) {
      const double value = effect[name].get<double>();
      figure.traces.push_back({name, style, TraceShape::kLine, {from, to}, {value, value}, {}, panel});
    }
  }
}

/// Both effects since the last change, with the tolerance as bands.
ReportFigure effect_figure(const RunFolder& run, const Json& state) {
  ReportFigure figure = figure_over_time(
      "health-effect", "What the calibration's error does", {{"off the line", "px"}, {"depth", "%"}},
      "Since the last change, with 95 % bounds, and the tolerance. Dots: a change was found.");
  for (std::size_t panel = 0; panel < 2; ++panel) {
    ReportTrace size{"size", kSizeStyle, TraceShape::kLine, {}, {}, {}, panel};
    ReportTrace low{"low", kSizeStyle, TraceShape::kBound, {}, {}, {}, panel}, high = low;
    ReportTrace change{"change", kChangeStyle, TraceShape::kDots, {}, {}, {}, panel};
    for (const HealthRow& row : run.health) {
      const double t = run.seconds(row.t_ns), unit = panel == 0 ? 1.0 : 100.0;
      const SizeInterval& interval = panel == 0 ? row.epipolar_px : row.depth;
      append(t, unit * interval.size, size);
      append(t, unit * interval.low, low);
      append(t, unit * interval.high, high);
      append(t, row.changed ? unit * interval.size : kNan, change);
    }
    figure.traces.insert(figure.traces.end(), {size, low, high, change});
    add_bands(run, state.at(panel == 0 ? "epipolar_px" : "depth_percent"), panel, figure);
  }
  return figure;
}

/// Three axes of theta from `first` on, window by window.
ReportFigure offset_figure(const std::vector<DrawnRun>& runs, std::size_t first, ReportFigure figure) {
  for (std::size_t panel = 0; panel < 3; ++panel) {
    const auto k = static_cast<Eigen::Index>(first + panel);
    for (const DrawnRun& run : runs) {
      ReportTrace delta{run.name, run.style, TraceShape::kLine, {}, {}, {}, panel};
      ReportTrace upper{"upper", run.style, TraceShape::kBound, {}, {}, {}, panel}, lower = upper;
      for (const HealthRow& row : run.run->health) {
        const double t = run.seconds(row.t_ns), value = in_degrees_and_mm(row.window_delta)(k);
        const double bound = k95 * in_degrees_and_mm(row.window_sigma)(k);
        append(t, value, delta);
        append(t, value + bound, upper);
        append(t, value - bound, lower);
      }
      figure.traces.insert(figure.traces.end(), {delta, upper, lower});
    }
  }
  return figure;
}

}  // namespace

std::vector<ReportFigure> offset_figures(const std::vector<DrawnRun>& runs, const std::string& id) {
  const std::string caption =
      "True minus assumed calibration of each window alone, with its 95 % interval (dotted).";
  return {offset_figure(runs, 0,
                        figure_over_time("health-rotation" + id, "Offset of the rig: rotation",
                                         {{"ax", "deg"}, {"ay", "deg"}, {"az", "deg"}}, caption)),
          offset_figure(runs, 3,
                        figure_over_time("health-translation" + id, "Offset of the rig: translation",
                                         {{"tx", "mm"}, {"ty", "mm"}, {"tz", "mm"}}, caption))};
}

ReportSection calibration_section(const RunFolder& run) {
  ReportSection section{"calibration", "Calibration", {}};
  if (run.health.empty()) {
    return section;
  }
  const Json& health = run.summary.at("health");
  const Json& state = health.at("present");
  section.blocks.emplace_back(ReportText{fmt::format("Verdict: {}.", health.value("verdict", ""))});
  section.blocks.emplace_back(tolerance_table(state));
  section.blocks.emplace_back(axis_table(state));
  section.blocks.emplace_back(stretch_table(health));
  section.blocks.emplace_back(effect_figure(run, state));
  for (ReportFigure& figure : offset_figures({{&run, "offset", kSizeStyle, run.trajectory.front().t_ns}})) {
    section.blocks.emplace_back(std::move(figure));
  }
  return section;
}

}  // namespace limber::detail
