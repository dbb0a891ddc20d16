// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "study_sections.hpp"

namespace limber::detail {
namespace {

std::string two_decimals(const std::optional<double>& value) {
  return value ? fmt::format("{:.{}f}", *value, *value < 100.0 ? 2 : 0) : "–";
}

std::string percent(const std::optional<double>& value) {
  return value ? fmt::format("{:.0f} %", 100.0 * *value) : "–";
}

TableCell runs_cell(const MethodSummary& s) {
  if (s.diverged == 0) {
    return {std::to_string(s.runs)};
  }
  return {fmt::format("{}, {} diverged{}", s.runs, s.diverged,
                      s.first_diverged_t ? fmt::format(" (first at {:.1f} s)", *s.first_diverged_t) : ""),
          TableCell::Mark::kBad};
}

bool is_told_the_truth(const StudyMethodResults& method) { return method.variant.method == Method::kOracle; }

/// Smallest position RMSE among the methods that could be used in earnest and never diverged.
double best_position(const StudyCaseResults& results) {
  double best = std::numeric_limits<double>::infinity();
  for (const StudyMethodResults& method : results.methods) {
    if (!is_told_the_truth(method) && method.summary.diverged == 0) {
      best = std::min(best, method.summary.position_rmse_m.value_or(best));
    }
  }
  return best;
}

TableCell position_cell(const StudyMethodResults& method, double best) {
  const MethodSummary& s = method.summary;
  const bool is_best = !is_told_the_truth(method) && s.diverged == 0 && s.position_rmse_m == best;
  return {digits(s.position_rmse_m), is_best ? TableCell::Mark::kBest : TableCell::Mark::kNone};
}

std::string bounds(const std::optional<Interval>& interval) {
  return interval ? fmt::format("{:.2f} to {:.2f}", interval->lower, interval->upper) : "–";
}

TableCell overview_cell(const StudyMethodResults& method, double best) {
  const MethodSummary& s = method.summary;
  TableCell cell = position_cell(method, best);
  cell.text += fmt::format(" ({})", two_decimals(s.anees));
  if (s.diverged == 0) {
    return cell;
  }
  return {
      fmt::format("{} of {} diverged{}", s.diverged, s.runs, s.position_rmse_m ? ", else " + cell.text : ""),
      TableCell::Mark::kBad};
}

const StudyMethodResults* find(const StudyCaseResults& results, const std::string& label) {
  const auto it = std::find_if(results.methods.begin(), results.methods.end(),
                               [&label](const auto& m) { return m.summary.label == label; });
  return it == results.methods.end() ? nullptr : &*it;
}

/// Methods with a walk of theta of their own, or all others.
ReportTable overview_table(const StudyResults& results, bool walks) {
  ReportTable table{"Position RMSE [m], in brackets ANEES", {"case", "runs"}, {}, ""};
  for (const StudyCaseResults& study_case : results.cases) {
    for (const StudyMethodResults& method : study_case.methods) {
      const std::string& label = method.summary.label;
      if (method.variant.walk.has_value() == walks &&
          std::find(table.columns.begin(), table.columns.end(), label) == table.columns.end()) {
        table.columns.push_back(label);
      }
    }
  }
  for (const StudyCaseResults& study_case : results.cases) {
    std::vector<TableCell> row = {{study_case.info.name}, {std::to_string(study_case.info.finished)}};
    const double best = best_position(study_case);
    bool any = false;
    for (std::size_t k = 2; k < table.columns.size(); ++k) {
      const StudyMethodResults* const method = find(study_case, table.columns[k]);
      any = any || method != nullptr;
      row.push_back(method != nullptr ? overview_cell(*method, best) : TableCell{});
    }
    if (any) {
      table.rows.push_back(std::move(row));
    }
  }
  table.note = "1 in brackets: the filter knows how wrong it is. Green: the best of the case, oracle aside.";
  if (walks) {
    table.title += ": ekf-full with other random walks";
    table.note += " x10: ten times the variances of the scenario; 2e-05/20: rad² and mm² per 10 ms.";
  }
  return table;
}

}  // namespace

std::string digits(const std::optional<double>& value) { return value ? fmt::format("{:.3g}", *value) : "–"; }

ReportTable case_table(const StudyCaseResults& results) {
  ReportTable table{
      "All methods",
      {"method", "runs", "position RMSE [m]", "worst run [m]", "attitude RMSE [deg]", "landmark RMSE [m]",
       "ANEES pose", "ANEES position", "ANEES attitude", "in bounds", "NIS / d.o.f.", "scale", "time [ms]"},
      {},
      ""};
  const double best = best_position(results);
  for (const StudyMethodResults& method : results.methods) {
    const MethodSummary& s = method.summary;
    table.rows.push_back({{s.label},
                          runs_cell(s),
                          position_cell(method, best),
                          {digits(s.position_rmse_worst_m)},
                          {digits(s.attitude_rmse_deg)},
                          {digits(s.landmark_rmse_m)},
                          {two_decimals(s.anees)},
                          {two_decimals(s.anees_position)},
                          {two_decimals(s.anees_attitude)},
                          {percent(s.share_within_interval)},
                          {two_decimals(s.nis_per_dof)},
                          {s.scale ? fmt::format("{:.4f}", *s.scale) : "–"},
                          {two_decimals(s.ms_per_frame)}});
  }
  if (!results.methods.empty()) {
    const MethodSummary& first = results.methods.front().summary;
    table.note = fmt::format(
        "Over the runs that did not diverge; diverged ones enter no average. RMSE: root mean square over "
        "runs and "
        "frames. ANEES: normalised error squared per degree of freedom, averaged over time and runs; 1 where "
        "the filter is consistent. 95 % χ² bounds of its mean over the runs ({}): pose {}, position and "
        "attitude "
        "{}. In bounds: instants whose mean over the runs lies within. Best position (oracle aside) in "
        "green.",
        first.label, bounds(first.anees_interval), bounds(first.anees_interval_3));
  }
  return table;
}

std::vector<ReportTable> overview_tables(const StudyResults& results) {
  std::vector<ReportTable> tables;
  for (const bool walks : {false, true}) {
    ReportTable table = overview_table(results, walks);
    if (!table.rows.empty() || !walks) {
      tables.push_back(std::move(table));
    }
  }
  return tables;
}

}  // namespace limber::detail
