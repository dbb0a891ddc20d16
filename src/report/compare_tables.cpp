// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <optional>
#include <string>

#include "compare_sections.hpp"
#include "limber/diagnose/health_summary.hpp"

namespace limber::detail {
namespace {

std::string digits(const std::optional<double>& value, const char* format = "{:.3g}") {
  return value ? fmt::format(fmt::runtime(format), *value) : "–";
}

TableCell end_cell(const ComparedRun& run) {
  return {end_in_words(run), run.end == RunEnd::kDone ? TableCell::Mark::kNone : TableCell::Mark::kBad};
}

TableCell verdict_cell(const ComparedRun& run) {
  const bool wrong = run.verdict == to_string(HealthVerdict::kDecalibrated);
  return {run.verdict.value_or("–"), wrong ? TableCell::Mark::kBad : TableCell::Mark::kNone};
}

ReportTable table_of(const std::vector<ComparedRun>& runs) {
  ReportTable table{"Runs",
                    {"run", "recording", "ATE [m]", "RPE [%]", "over [m]", "attitude [deg]", "ANEES",
                     "scale [%]", "calibration", "ms a frame (p99)", "end"},
                    {},
                    "ATE: RMSE after a rigid fit; attitude: after the run's own alignment. RPE: mean over "
                    "disjoint pieces of the path. ANEES: "
                    "1 where the filter knows how wrong it is. Scale: error of the estimate. –: not known."};
  for (const ComparedRun& run : runs) {
    table.rows.push_back(
        {{run.label},
         {run.recording},
         {digits(run.ate_m)},
         {digits(run.rpe_percent, "{:.2f}")},
         {run.rpe_percent ? fmt::format("{:g}", run.piece_m) : "–"},
         {digits(run.attitude_rmse_deg)},
         {digits(run.anees, "{:.2f}")},
         {digits(run.scale_error_percent, "{:+.2f}")},
         verdict_cell(run),
         {fmt::format("{} ({})", digits(run.ms_per_frame, "{:.2f}"), digits(run.ms_per_frame_p99, "{:.2f}"))},
         end_cell(run)});
  }
  return table;
}

TableCell difference_cell(const std::optional<MeanInterval>& difference) {
  if (!difference) {
    return {"–"};
  }
  const Judgement judgement = judge(*difference);
  return {difference_in_words(*difference), judgement == Judgement::kBetter  ? TableCell::Mark::kBest
                                            : judgement == Judgement::kWorse ? TableCell::Mark::kBad
                                                                             : TableCell::Mark::kNone};
}

ReportTable table_of(const RunComparison& comparison) {
  ReportTable table{
      "Differences",
      {"run", "minus", "pieces", "RPE [%]", "RPE [deg a piece]", "ATE [m]", "apart [m]",
       "apart at the end [m]"},
      {},
      "RPE: mean of the differences piece by piece, with its 95 % interval; 'cannot tell' where that "
      "holds zero. ATE is one number a recording and has none. Apart: distance between the runs (RMS), "
      "position and yaw of their first poses put together."};
  for (const RunDifference& difference : comparison.differences) {
    table.rows.push_back({{comparison.runs[difference.run].label},
                          {comparison.runs[difference.against].label},
                          {difference.rpe_percent ? std::to_string(difference.rpe_percent->count) : "–"},
                          difference_cell(difference.rpe_percent),
                          difference_cell(difference.rpe_deg),
                          {digits(difference.ate_m, "{:+.3g}")},
                          {digits(difference.apart_rms_m)},
                          {digits(difference.apart_end_m)}});
  }
  return table;
}

}  // namespace

ReportSection comparison_section(const RunComparison& comparison) {
  ReportSection section{"comparison", "Comparison", {}};
  section.blocks.emplace_back(table_of(comparison.runs));
  if (!comparison.differences.empty()) {
    section.blocks.emplace_back(table_of(comparison));
  }
  for (const std::string& note : comparison.notes) {
    section.blocks.emplace_back(ReportText{"• " + note + "."});
  }
  return section;
}

}  // namespace limber::detail
