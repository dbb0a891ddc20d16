// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "limber/evaluate/consistency.hpp"
#include "limber/study/study_database.hpp"

namespace limber {

/// What a table says of one method in one case. Averages are over the runs that did not diverge; `diverged`
/// stands beside them. Empty where there is no such run.
struct MethodSummary {
  std::string label;
  std::uint64_t runs = 0;                  ///< finished, diverged ones included
  std::uint64_t diverged = 0;              ///< of them
  std::optional<double> first_diverged_t;  ///< earliest time of a divergence [s]

  std::optional<double> position_rmse_m, attitude_rmse_deg,
      landmark_rmse_m;                          ///< root of the mean square over runs
  std::optional<double> position_rmse_worst_m;  ///< of a single run
  std::optional<double> position_final_m;  ///< root mean square over runs of the error after the last frame
  std::optional<double> anees, anees_position, anees_attitude;  ///< mean over runs; 1 = consistent
  std::optional<double> anees_standard_error;                   ///< of `anees`, from the spread between runs
  /// 95 % interval of the mean over as many independent runs at one instant, per d.o.f.: the bounds that the
  /// NEES curve of a consistent filter leaves at one instant in twenty; and, since frames of one run may
  /// correlate fully, cautious bounds of the time average. Three d.o.f.: position and attitude.
  std::optional<Interval> anees_interval, anees_interval_3;
  std::optional<double>
      share_within_interval;  ///< of instants later than 1 s, at which the mean NEES is within
  std::optional<double> nis_per_dof;
  std::optional<double> scale;  ///< mean over runs of the Sim(3) scale
  std::optional<double> ms_per_frame;
};

/// One per method of the case, in its order.
[[nodiscard]] std::vector<MethodSummary> summarize_case(const StudyDatabase& database,
                                                        std::size_t study_case);

/// One case as a Markdown table, a line per method.
[[nodiscard]] std::string format_case_table(const StudyDatabase& database, std::size_t study_case);

/// All cases, each a line that names it and its table: what the program prints.
[[nodiscard]] std::string format_study_table(const StudyDatabase& database);

}  // namespace limber
