// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "limber/evaluate/consistency.hpp"
#include "limber/evaluate/statistics.hpp"
#include "limber/study/study_database.hpp"

namespace limber {

/// What a table says of one method in one case. Averages are over the runs that did not diverge; `diverged`
/// stands beside them. Empty where there is no such run.
struct MethodSummary {
  /// of the method, as to_string(MethodVariant)
  std::string label;
  std::uint64_t runs = 0;                  ///< finished, diverged ones included
  std::uint64_t diverged = 0;              ///< of them
  std::optional<double> first_diverged_t;  ///< earliest time of a divergence [s]
  /// of them that went through but were lost, as `limber run` says of them
  std::uint64_t lost = 0;

  std::optional<double> position_rmse_m, attitude_rmse_deg,
      landmark_rmse_m;                          ///< root of the mean square over runs
  std::optional<double> position_rmse_worst_m;  ///< of a single run
  /// Over runs, a diverged one being worse than any other: infinite where most of them are.
  std::optional<MedianInterval> position_rmse_median_m;
  /// of ANEES, over runs as the one above
  std::optional<MedianInterval> anees_median;
  std::optional<double> ate_se3_m;         ///< root of the mean square over runs
  std::optional<double> position_final_m;  ///< root mean square over runs of the error after the last frame
  std::optional<double> anees, anees_position, anees_attitude,
      anees_scale;                             ///< mean over runs; 1 = consistent
  std::optional<double> anees_standard_error;  ///< of `anees`, from the spread between runs
  /// 95 % interval of the mean over as many independent runs at one instant, per d.o.f.: the bounds that the
  /// NEES curve of a consistent filter leaves at one instant in twenty; and, since frames of one run may
  /// correlate fully, cautious bounds of the time average. Three d.o.f.: position and attitude.
  std::optional<Interval> anees_interval, anees_interval_3;
  std::optional<double>
      share_within_interval;  ///< of instants later than 1 s, at which the mean NEES is within
  /// mean over runs; 1 = consistent
  std::optional<double> nis_per_dof;
  std::optional<double> scale;                          ///< mean over runs of the Sim(3) scale
  std::optional<double> start_median_s, start_worst_s;  ///< until a start from the sensors was ready
  /// mean over runs of the filter's time [ms]
  std::optional<double> ms_per_frame;
};

/// One per method of the case, in its order.
[[nodiscard]] std::vector<MethodSummary> summarize_case(const StudyDatabase& database,
                                                        std::size_t study_case);

/// "from the sensors (--init auto)" or "from the truth (--init groundtruth)"
[[nodiscard]] std::string start_in_words(StartMode start);

/// One case as a Markdown table, a line per method.
[[nodiscard]] std::string format_case_table(const StudyDatabase& database, std::size_t study_case);

/// The main figures of one method of one case, for a table of all.
struct BriefRow {
  /// label: of the method; runs: how many, and how many diverged
  std::string label, runs;
  std::string position;    ///< median over the runs of the position RMSE [m], in brackets its 95 % interval
  std::string worst;       ///< of a run [m]
  std::string to_best;     ///< median over that of the case's best method
  std::string anees;       ///< median over the runs, in brackets its 95 % interval
  std::string to_claimed;  ///< root of that: how many times as large as claimed the errors are
  bool is_best = false;    ///< smallest median of the methods that were not told the truth
  bool is_overconfident = false;  ///< errors more than twice as large as claimed, or diverged
};

/// The heads of a BriefRow behind the case's name, in its order.
[[nodiscard]] const std::array<std::string, 7>& brief_heads();
/// One row per method, in their order.
[[nodiscard]] std::vector<BriefRow> brief_rows(const std::vector<MethodSummary>& methods);

/// All cases in one table of the main figures.
[[nodiscard]] std::string format_brief_table(const StudyDatabase& database);

/// All cases, each a line that names it and its table: what the program prints.
[[nodiscard]] std::string format_study_table(const StudyDatabase& database);

}  // namespace limber
