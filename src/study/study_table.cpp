// SPDX-License-Identifier: MIT
#include "limber/study/study_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace limber {
namespace {

constexpr double kOverconfident = 2.0;  // errors over what is claimed

using Figure = std::optional<double> RunFigures::*;

/// The known values of one figure, of the runs that did not diverge.
std::vector<double> values_of(const std::vector<StudyRun>& runs, Figure figure) {
  std::vector<double> values;
  for (const StudyRun& run : runs) {
    if (!run.diverged && run.figures.*figure) {
      values.push_back(*(run.figures.*figure));
    }
  }
  return values;
}

std::optional<double> mean(const std::vector<double>& values) {
  if (values.empty()) {
    return std::nullopt;
  }
  double sum = 0.0;
  for (const double value : values) {
    sum += value;
  }
  return sum / static_cast<double>(values.size());
}

std::optional<double> root_mean_square(std::vector<double> values) {
  for (double& value : values) {
    value *= value;
  }
  const std::optional<double> square = mean(values);
  return square ? std::optional(std::sqrt(*square)) : std::nullopt;
}

std::optional<double> standard_error(const std::vector<double>& values) {
  if (values.size() < 2) {
    return std::nullopt;
  }
  const double centre = *mean(values);
  double sum = 0.0;
  for (const double value : values) {
    sum += (value - centre) * (value - centre);
  }
  const auto n = static_cast<double>(values.size());
  return std::sqrt(sum / (n - 1.0) / n);
}

std::optional<double> nis_per_dof(const std::vector<StudyRun>& runs) {
  double nis = 0.0, dof = 0.0;
  for (const StudyRun& run : runs) {
    nis += run.figures.nis.value_or(0.0);
    dof += run.figures.nis_dof.value_or(0.0);
  }
  return dof > 0.0 ? std::optional(nis / dof) : std::nullopt;
}

/// Over all runs, a diverged one being worse than any other.
std::optional<MedianInterval> median_of(const std::vector<StudyRun>& runs, Figure figure) {
  std::vector<double> values = values_of(runs, figure);
  for (const StudyRun& run : runs) {
    if (run.diverged) {
      values.push_back(std::numeric_limits<double>::infinity());
    }
  }
  return values.size() == runs.size() ? median_interval(values) : std::nullopt;
}

/// Share of the instants later than kNeesSkip at which the mean NEES over the runs is where chi-square puts
/// it.
std::optional<double> share_within(const StudyCurve& nees, const std::vector<double>& times) {
  constexpr double kDof = 6.0;
  std::size_t within = 0, instants = 0;
  for (std::size_t k = 0; k < times.size(); ++k) {
    if (times[k] <= kNeesSkip || nees.count[k] == 0) {
      continue;
    }
    const Interval interval = normalized_mean_interval(kDof, nees.count[k]);
    const double per_dof = nees.mean[k] / kDof;
    ++instants;
    within += per_dof >= interval.lower && per_dof <= interval.upper ? 1 : 0;
  }
  return instants > 0 ? std::optional(static_cast<double>(within) / static_cast<double>(instants))
                      : std::nullopt;
}

void count_runs(const std::vector<StudyRun>& runs, MethodSummary& out) {
  out.runs = runs.size();
  for (const StudyRun& run : runs) {
    out.lost += run.figures.lost_s ? 1 : 0;
    if (run.diverged) {
      ++out.diverged;
      out.first_diverged_t = std::min(out.first_diverged_t.value_or(run.diverged->t), run.diverged->t);
    }
  }
}

MethodSummary summarize_method(const StudyDatabase& database, std::size_t study_case, std::size_t method) {
  const StudyCaseInfo& info = database.info().cases[study_case];
  const std::vector<StudyRun> runs = database.runs(study_case, method);
  MethodSummary out;
  out.label = info.labels[method];
  count_runs(runs, out);
  const std::vector<double> position = values_of(runs, &RunFigures::position_rmse_m);
  out.position_rmse_m = root_mean_square(position);
  out.position_rmse_median_m = median_of(runs, &RunFigures::position_rmse_m);
  out.anees_median = median_of(runs, &RunFigures::anees);
  out.ate_se3_m = root_mean_square(values_of(runs, &RunFigures::ate_se3_m));
  out.attitude_rmse_deg = root_mean_square(values_of(runs, &RunFigures::attitude_rmse_deg));
  out.landmark_rmse_m = root_mean_square(values_of(runs, &RunFigures::landmark_rmse_m));
  out.position_final_m = root_mean_square(values_of(runs, &RunFigures::position_final_m));
  const std::vector<double> anees = values_of(runs, &RunFigures::anees);
  out.anees = mean(anees);
  out.anees_standard_error = standard_error(anees);
  out.anees_position = mean(values_of(runs, &RunFigures::anees_position));
  out.anees_attitude = mean(values_of(runs, &RunFigures::anees_attitude));
  out.anees_scale = mean(values_of(runs, &RunFigures::anees_scale));
  out.nis_per_dof = nis_per_dof(runs);
  out.scale = mean(values_of(runs, &RunFigures::scale));
  out.ms_per_frame = mean(values_of(runs, &RunFigures::ms_per_frame_mean));
  if (const std::vector<double> started = values_of(runs, &RunFigures::start_s); !started.empty()) {
    const Statistics s = statistics_of(started);
    out.start_median_s = s.median;
    out.start_worst_s = s.max;
  }
  if (!position.empty()) {
    out.position_rmse_worst_m = *std::max_element(position.begin(), position.end());
    out.anees_interval = normalized_mean_interval(6.0, position.size());
    out.anees_interval_3 = normalized_mean_interval(3.0, position.size());
  }
  if (const auto nees = database.curve(study_case, method, CurveQuantity::kPoseNees)) {
    out.share_within_interval = share_within(*nees, info.frame_times);
  }
  return out;
}

using Row = std::vector<std::string>;

std::string cell(const std::optional<double>& value, int digits) {
  return value ? fmt::format("{:.{}g}", *value, digits) : "-";
}

std::string fixed_cell(const std::optional<double>& value, int digits) {
  if (value && std::abs(*value) >= 1000.0) {
    return fmt::format("{:.3g}", *value);
  }
  return value ? fmt::format("{:.{}f}", *value, digits) : "-";
}

std::string runs_cell(const MethodSummary& s) {
  std::string text;
  if (s.diverged > 0) {
    text = fmt::format("{} diverged, first at {:.1f} s", s.diverged, s.first_diverged_t.value_or(0.0));
  }
  if (s.lost > 0) {
    text += fmt::format("{}{} lost", text.empty() ? "" : "; ", s.lost);
  }
  return text.empty() ? fmt::format("{}", s.runs) : fmt::format("{} ({})", s.runs, text);
}

std::string finite_cell(double value, int digits) {
  return std::isfinite(value) ? fmt::format("{:.{}g}", value, digits) : std::string("diverged");
}

std::string median_cell(const std::optional<MedianInterval>& median, int digits) {
  if (!median) {
    return "-";
  }
  std::string text = finite_cell(median->median, digits);
  if (median->lower && median->upper) {
    text += fmt::format(" ({}-{})", finite_cell(*median->lower, digits), finite_cell(*median->upper, digits));
  }
  return text;
}

std::string start_cell(const MethodSummary& s) {
  return s.start_median_s ? fmt::format("{:.1f} (worst {:.1f})", *s.start_median_s, *s.start_worst_s) : "-";
}

bool is_told_the_truth(const MethodSummary& s) {
  return method_variant_from_string(s.label).method == Method::kOracle;
}

Row row_of(const MethodSummary& s) {
  return {
      s.label,
      runs_cell(s),
      cell(s.position_rmse_m, 4),
      median_cell(s.position_rmse_median_m, 3),
      cell(s.position_rmse_worst_m, 3),
      cell(s.position_final_m, 3),
      cell(s.ate_se3_m, 3),
      cell(s.attitude_rmse_deg, 3),
      cell(s.landmark_rmse_m, 3),
      fixed_cell(s.anees, 2) + (s.anees_standard_error ? " ± " + fixed_cell(s.anees_standard_error, 2) : ""),
      fixed_cell(s.anees_position, 2),
      fixed_cell(s.anees_attitude, 2),
      fixed_cell(s.anees_scale, 2),
      s.anees_interval ? fmt::format("{:.2f}-{:.2f}", s.anees_interval->lower, s.anees_interval->upper) : "-",
      s.share_within_interval ? fmt::format("{:.0f} %", 100.0 * *s.share_within_interval) : "-",
      fixed_cell(s.nis_per_dof, 3),
      fixed_cell(s.scale, 4),
      start_cell(s),
      fixed_cell(s.ms_per_frame, 2)};
}

/// Characters, not bytes, of UTF-8.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

std::string format_table(const std::vector<Row>& rows) {
  std::vector<std::size_t> widths(rows.front().size(), 3);
  for (const Row& row : rows) {
    for (std::size_t k = 0; k < row.size(); ++k) {
      widths[k] = std::max(widths[k], width_of(row[k]));
    }
  }
  std::string text;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (std::size_t k = 0; k < rows[r].size(); ++k) {
      text += "| " + rows[r][k] + std::string(widths[k] - width_of(rows[r][k]) + 1, ' ');
    }
    text += "|\n";
    for (std::size_t k = 0; r == 0 && k < widths.size(); ++k) {
      text += "| " + std::string(widths[k], '-') + " ";
    }
    text += r == 0 ? "|\n" : "";
  }
  return text;
}

}  // namespace

std::vector<MethodSummary> summarize_case(const StudyDatabase& database, std::size_t study_case) {
  std::vector<MethodSummary> out;
  for (std::size_t method = 0; method < database.info().cases.at(study_case).methods.size(); ++method) {
    out.push_back(summarize_method(database, study_case, method));
  }
  return out;
}

std::string start_in_words(StartMode start) {
  return fmt::format("from the {} (--init {})", start == StartMode::kAuto ? "sensors" : "truth",
                     name_of(start));
}

std::string format_case_table(const StudyDatabase& database, std::size_t study_case) {
  std::vector<Row> rows = {{"method", "runs", "position RMSE [m]", "median (95 %)", "worst [m]", "final [m]",
                            "SE(3) ATE [m]", "attitude RMSE [deg]", "landmarks [m]", "ANEES", "of position",
                            "of attitude", "of scale", "95 % bounds", "inside", "NIS/dof", "scale",
                            "started [s]", "ms/frame"}};
  for (const MethodSummary& summary : summarize_case(database, study_case)) {
    rows.push_back(row_of(summary));
  }
  return format_table(rows);
}

const std::array<std::string, 7>& brief_heads() {
  static const std::array<std::string, 7> kHeads = {"method",
                                                    "position RMSE [m]: median (95 %)",
                                                    "times the best",
                                                    "error / claimed",
                                                    "worst [m]",
                                                    "ANEES: median (95 %)",
                                                    "runs"};
  return kHeads;
}

std::vector<BriefRow> brief_rows(const std::vector<MethodSummary>& methods) {
  double best = std::numeric_limits<double>::infinity();
  for (const MethodSummary& s : methods) {
    if (s.position_rmse_median_m && !is_told_the_truth(s)) {
      best = std::min(best, s.position_rmse_median_m->median);
    }
  }
  std::vector<BriefRow> rows;
  for (const MethodSummary& s : methods) {
    BriefRow row{s.label, runs_cell(s), median_cell(s.position_rmse_median_m, 3), "", "-", "", "-"};
    row.worst = s.diverged > 0 ? "diverged" : cell(s.position_rmse_worst_m, 3);
    row.anees = median_cell(s.anees_median, 3);
    if (s.position_rmse_median_m && std::isfinite(s.position_rmse_median_m->median)) {
      row.to_best = fmt::format("{:.1f}", s.position_rmse_median_m->median / best);
      row.is_best = !is_told_the_truth(s) && s.position_rmse_median_m->median == best;
    }
    if (s.anees_median) {
      const double to_claimed = std::sqrt(s.anees_median->median);
      row.is_overconfident = to_claimed > kOverconfident;
      row.to_claimed =
          std::isfinite(to_claimed) ? fmt::format("{:.1f}", to_claimed) : std::string("diverged");
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

std::string format_brief_table(const StudyDatabase& database) {
  std::vector<Row> rows = {{"case"}};
  rows.front().insert(rows.front().end(), brief_heads().begin(), brief_heads().end());
  std::string starts;
  for (std::size_t k = 0; k < database.info().cases.size(); ++k) {
    const StudyCaseInfo& info = database.info().cases[k];
    for (const BriefRow& row : brief_rows(summarize_case(database, k))) {
      rows.push_back(
          {info.name, row.label, row.position, row.to_best, row.to_claimed, row.worst, row.anees, row.runs});
    }
    const std::string start = start_in_words(info.start);
    if (starts.find(start) == std::string::npos) {
      starts += (starts.empty() ? "" : " and ") + start;
    }
  }
  return format_table(rows) + "\nStarted " + starts +
         ". ANEES: squared pose error over the claimed variance; 1: the filter knows how wrong it is.\n";
}

std::string format_study_table(const StudyDatabase& database) {
  std::string text;
  for (std::size_t k = 0; k < database.info().cases.size(); ++k) {
    const StudyCaseInfo& info = database.info().cases[k];
    text += fmt::format("{}{}: {} of {} runs, started {}\n\n{}", k == 0 ? "" : "\n", info.name, info.finished,
                        info.runs, start_in_words(info.start), format_case_table(database, k));
  }
  return text;
}

}  // namespace limber
