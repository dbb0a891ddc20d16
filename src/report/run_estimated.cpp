// SPDX-License-Identifier: MIT
// What the filter estimated of the calibration.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "limber/io/parameter_text.hpp"
#include "run_sections.hpp"

namespace limber::detail {
namespace {

constexpr std::size_t kPanels = 3;  // parameters a figure
constexpr std::array<const char*, kParameterNames.size() / kPanels> kTitles = {
    "Rig: rotation",
    "Rig: translation",
    "Left camera: focal lengths, principal point",
    "Left camera: principal point, distortion, time offset",
    "Right camera: focal lengths, principal point",
    "Right camera: principal point, distortion, time offset",
    "Mount on the body: rotation",
    "Mount on the body: translation"};

bool estimates(const DrawnRun& drawn, std::size_t parameter) {
  return !drawn.run->calibration.empty() && drawn.run->calibration.back().estimate.parameters[parameter];
}

/// One parameter over time, with three standard deviations about it, into the last panel.
void draw(const DrawnRun& run, std::size_t parameter, ReportFigure& figure) {
  const std::size_t panel = figure.y.size() - 1;
  ReportTrace estimate{run.name, run.style, TraceShape::kLine, {}, {}, {}, panel};
  ReportTrace upper{"+3 sigma", run.style, TraceShape::kBound, {}, {}, {}, panel};
  ReportTrace lower{"-3 sigma", run.style, TraceShape::kBound, {}, {}, {}, panel};
  const auto k = static_cast<Eigen::Index>(parameter);
  for (const CalibrationRow& row : run.run->calibration) {
    const double t = run.seconds(row.t_ns);
    const double value = in_user_units(parameter, row.estimate.error(k));
    const double bound = 3.0 * in_user_units(parameter, row.estimate.sigma(k));
    for (const auto& [trace, y] :
         {std::pair(&estimate, value), std::pair(&upper, value + bound), std::pair(&lower, value - bound)}) {
      trace->x.push_back(t);
      trace->y.push_back(y);
    }
  }
  figure.traces.push_back(std::move(estimate));
  figure.traces.push_back(std::move(upper));
  figure.traces.push_back(std::move(lower));
}

}  // namespace

std::vector<ReportFigure> estimated_figures(const std::vector<DrawnRun>& runs, const std::string& id) {
  std::vector<ReportFigure> figures;
  for (std::size_t group = 0; group < kTitles.size(); ++group) {
    ReportFigure figure = figure_over_time(
        fmt::format("estimated-{}{}", group, id), kTitles[group], {},
        "True minus assumed calibration as the filter estimates it; dotted: three standard deviations.");
    for (std::size_t k = group * kPanels; k < (group + 1) * kPanels; ++k) {
      if (std::none_of(runs.begin(), runs.end(), [k](const DrawnRun& run) { return estimates(run, k); })) {
        continue;
      }
      figure.y.push_back({std::string(kParameterNames[k]), user_unit_of(k)});
      for (const DrawnRun& run : runs) {
        if (estimates(run, k)) {
          draw(run, k, figure);
        }
      }
    }
    if (!figure.y.empty()) {
      figures.push_back(std::move(figure));
    }
  }
  return figures;
}

ReportSection estimated_section(const RunFolder& run) {
  ReportSection section{"estimated", "Estimated calibration", {}};
  for (ReportFigure& figure :
       estimated_figures({{&run, "estimate", run.method, run.trajectory.front().t_ns}})) {
    section.blocks.emplace_back(std::move(figure));
  }
  return section;
}

}  // namespace limber::detail
