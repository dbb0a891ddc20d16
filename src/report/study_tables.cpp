// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "study_sections.hpp"

namespace limber::detail {
namespace {

std::string two_decimals(const std::optional<double>& value) {
  return value ? fmt::format("{:.{}f}", *value, *value < 100.0 ? 2 : 0) : "–";
}

std::string percent(const std::optional<double>& value) {
  return value ? fmt::format("{:.0f} %", 100.0 * *value) : "–";
}

std::vector<MethodSummary> summaries_of(const StudyCaseResults& results) {
  std::vector<MethodSummary> out;
  for (const StudyMethodResults& method : results.methods) {
    out.push_back(method.summary);
  }
  return out;
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

/// Labels of the methods of a case that have a walk of theta of their own, or of all others.
std::vector<std::string> labels_of(const StudyCaseResults& results, bool walks) {
  std::vector<std::string> labels;
  for (const StudyMethodResults& method : results.methods) {
    if (method.variant.walk.has_value() == walks) {
      labels.push_back(method.summary.label);
    }
  }
  return labels;
}

void append_new(const std::vector<std::string>& labels, std::vector<std::string>& all) {
  for (const std::string& label : labels) {
    if (std::find(all.begin(), all.end(), label) == all.end()) {
      all.push_back(label);
    }
  }
}

std::vector<TableCell> overview_row(const StudyCaseResults& results, const std::vector<std::string>& labels) {
  std::vector<TableCell> row = {{results.info.name}, {std::to_string(results.info.finished)}};
  const double best = best_position(results);
  for (const std::string& label : labels) {
    const StudyMethodResults* const method = find(results, label);
    row.push_back(method != nullptr ? overview_cell(*method, best) : TableCell{});
  }
  return row;
}

/// The named methods in those cases that have any of them.
ReportTable overview_table(const StudyResults& results, const std::vector<std::string>& labels) {
  ReportTable table{"Position RMSE [m], in brackets ANEES", {"case", "runs"}, {}, ""};
  table.columns.insert(table.columns.end(), labels.begin(), labels.end());
  for (const StudyCaseResults& study_case : results.cases) {
    if (std::any_of(labels.begin(), labels.end(),
                    [&](const std::string& label) { return find(study_case, label) != nullptr; })) {
      table.rows.push_back(overview_row(study_case, labels));
    }
  }
  table.note = "1 in brackets: the filter knows how wrong it is. Green: the best of the case, oracle aside.";
  return table;
}

ReportTable walks_table(const StudyResults& results, const std::vector<std::string>& labels) {
  ReportTable table = overview_table(results, labels);
  table.title += ": ekf-full with other random walks";
  table.note += " x10: ten times the variances of the scenario; 2e-05/20: rad² and mm² per 10 ms.";
  return table;
}

}  // namespace

std::string digits(const std::optional<double>& value) { return value ? fmt::format("{:.3g}", *value) : "–"; }

ReportTable answer_table(const StudyResults& results) {
  ReportTable table{"Who gets how far, and knows it", {"case"}, {}, ""};
  table.columns.insert(table.columns.end(), brief_heads().begin(), brief_heads().end());
  for (const StudyCaseResults& study_case : results.cases) {
    std::string name = study_case.info.name;
    const std::vector<BriefRow> brief = brief_rows(summaries_of(study_case));
    for (std::size_t k = 0; k < brief.size(); ++k) {
      const BriefRow& row = brief[k];
      const auto position = row.is_best ? TableCell::Mark::kBest : TableCell::Mark::kNone;
      const auto claimed = row.is_overconfident ? TableCell::Mark::kBad : TableCell::Mark::kNone;
      table.rows.push_back({{std::exchange(name, "")},
                            {row.label},
                            {row.position, position},
                            {row.to_best, position},
                            {row.to_claimed, claimed},
                            {row.worst},
                            {row.anees},
                            runs_cell(study_case.methods[k].summary)});
    }
  }
  table.note =
      "Median over the runs with the interval that holds the true one with 95 %, from six runs on. Green: "
      "the "
      "best of a case, oracle aside. Error / claimed: the root of ANEES, how many times as large as the "
      "filter "
      "claims its errors are; red above 2.";
  return table;
}

ReportTable case_table(const StudyCaseResults& results) {
  ReportTable table{"All methods",
                    {"method", "runs", "position RMSE [m]", "median (95 %)", "worst run [m]",
                     "attitude RMSE [deg]", "landmark RMSE [m]", "ANEES pose", "ANEES position",
                     "ANEES attitude", "ANEES scale", "in bounds", "NIS / d.o.f.", "scale", "time [ms]"},
                    {},
                    ""};
  const double best = best_position(results);
  const std::vector<BriefRow> brief = brief_rows(summaries_of(results));
  for (std::size_t k = 0; k < results.methods.size(); ++k) {
    const StudyMethodResults& method = results.methods[k];
    const MethodSummary& s = method.summary;
    table.rows.push_back({{s.label},
                          runs_cell(s),
                          position_cell(method, best),
                          {brief[k].position},
                          {digits(s.position_rmse_worst_m)},
                          {digits(s.attitude_rmse_deg)},
                          {digits(s.landmark_rmse_m)},
                          {two_decimals(s.anees)},
                          {two_decimals(s.anees_position)},
                          {two_decimals(s.anees_attitude)},
                          {two_decimals(s.anees_scale)},
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
  std::vector<std::string> labels;
  std::vector<std::vector<std::string>> walks;  // sets of them that some case has
  for (const StudyCaseResults& study_case : results.cases) {
    append_new(labels_of(study_case, false), labels);
    const std::vector<std::string> own = labels_of(study_case, true);
    if (!own.empty() && std::find(walks.begin(), walks.end(), own) == walks.end()) {
      walks.push_back(own);
    }
  }
  std::vector<ReportTable> tables = {overview_table(results, labels)};
  for (const std::vector<std::string>& set : walks) {
    tables.push_back(walks_table(results, set));
  }
  return tables;
}

}  // namespace limber::detail
