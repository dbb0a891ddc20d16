// SPDX-License-Identifier: MIT
// Relative errors over pieces of several lengths.
#include <fmt/format.h>

#include <utility>

#include "limber/evaluate/error_over_distance.hpp"
#include "run_sections.hpp"

namespace limber::detail {
namespace {

/// Median of one kind of error over the lengths, and its quartiles.
void draw(const DrawnRun& run, const std::vector<ErrorOverDistance>& errors,
          ErrorSpread ErrorOverDistance::*part, std::size_t panel, ReportFigure& figure) {
  ReportTrace median{run.name, run.style, TraceShape::kLine, {}, {}, {}, panel};
  ReportTrace lower{"lower quartile", run.style, TraceShape::kBound, {}, {}, {}, panel};
  ReportTrace upper{"upper quartile", run.style, TraceShape::kBound, {}, {}, {}, panel};
  for (const ErrorOverDistance& error : errors) {
    const ErrorSpread& spread = error.*part;
    for (const auto& [trace, y] : {std::pair(&median, spread.median), std::pair(&lower, spread.lower),
                                   std::pair(&upper, spread.upper)}) {
      trace->x.push_back(error.distance);
      trace->y.push_back(y);
    }
  }
  for (ReportTrace* trace : {&median, &lower, &upper}) {
    figure.traces.push_back(std::move(*trace));
  }
}

std::vector<ErrorOverDistance> errors_of(const RunFolder& run) {
  return errors_over_distances(run.matched, round_distances(run.matched));
}

ReportTable distance_table(const std::vector<ErrorOverDistance>& errors) {
  ReportTable table{
      "Drift",
      {"over [m]", "pieces", "position, mean [%]", "median [%]", "attitude, mean [deg]", "median [deg]"},
      {},
      "As limber evaluate has it. Pieces begin at every frame, so they overlap."};
  for (const ErrorOverDistance& error : errors) {
    table.rows.push_back({{fmt::format("{:g}", error.distance)},
                          {std::to_string(error.pairs)},
                          {fmt::format("{:.3g}", error.position_percent.mean)},
                          {fmt::format("{:.3g}", error.position_percent.median)},
                          {fmt::format("{:.3g}", error.attitude_deg.mean)},
                          {fmt::format("{:.3g}", error.attitude_deg.median)}});
  }
  return table;
}

}  // namespace

ReportFigure distance_figure(const std::vector<DrawnRun>& runs, const std::string& id) {
  ReportFigure figure;
  figure.id = "error-over-distance" + id;
  figure.title = "Relative error over distance";
  figure.caption =
      "Median over all pieces of the path of that length, position in % of it; dotted: quartiles. No "
      "alignment enters.";
  figure.x = {"distance", "m", true};
  figure.y = {{"position", "%"}, {"attitude", "deg"}};
  for (const DrawnRun& run : runs) {
    const std::vector<ErrorOverDistance> errors = errors_of(*run.run);
    if (!errors.empty()) {
      draw(run, errors, &ErrorOverDistance::position_percent, 0, figure);
      draw(run, errors, &ErrorOverDistance::attitude_deg, 1, figure);
    }
  }
  return figure;
}

ReportSection distance_section(const RunFolder& run) {
  ReportSection section{"drift", "Error over distance", {}};
  ReportFigure figure = distance_figure({{&run, run.method, run.method, run.trajectory.front().t_ns}});
  if (!figure.traces.empty()) {
    section.blocks.emplace_back(std::move(figure));
    section.blocks.emplace_back(distance_table(errors_of(run)));
  }
  return section;
}

}  // namespace limber::detail
