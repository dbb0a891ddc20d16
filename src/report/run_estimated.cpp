// SPDX-License-Identifier: MIT
// What the filter estimated of the calibration.
#include <fmt/format.h>

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

/// One parameter over time, with three standard deviations about it.
void draw(const RunFolder& run, std::size_t parameter, ReportFigure& figure) {
  const std::size_t panel = figure.y.size();
  figure.y.push_back({std::string(kParameterNames[parameter]), user_unit_of(parameter)});
  ReportTrace estimate{"estimate", run.method, TraceShape::kLine, {}, {}, {}, panel};
  ReportTrace upper{"+3 sigma", run.method, TraceShape::kBound, {}, {}, {}, panel};
  ReportTrace lower{"-3 sigma", run.method, TraceShape::kBound, {}, {}, {}, panel};
  const auto k = static_cast<Eigen::Index>(parameter);
  for (const CalibrationRow& row : run.calibration) {
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

ReportSection estimated_section(const RunFolder& run) {
  ReportSection section{"estimated", "Estimated calibration", {}};
  const ParameterSet& parameters = run.calibration.back().estimate.parameters;
  for (std::size_t group = 0; group < kTitles.size(); ++group) {
    ReportFigure figure = figure_over_time(
        fmt::format("estimated-{}", group), kTitles[group], {},
        "True minus assumed calibration as the filter estimates it; dotted: three standard deviations.");
    for (std::size_t k = group * kPanels; k < (group + 1) * kPanels; ++k) {
      if (parameters[k]) {
        draw(run, k, figure);
      }
    }
    if (!figure.y.empty()) {
      section.blocks.emplace_back(std::move(figure));
    }
  }
  return section;
}

}  // namespace limber::detail
