// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "limber/core/time.hpp"
#include "limber/report/document.hpp"
#include "run_files/run_folder.hpp"

/// The sections of a run's report, in order.
namespace limber::detail {

/// Where a curve has no value.
inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// A run among the curves of a figure.
struct DrawnRun {
  const RunFolder* run = nullptr;
  std::string name, style;   ///< of its curves
  std::int64_t zero_ns = 0;  ///< where time begins

  [[nodiscard]] double seconds(std::int64_t t_ns) const { return seconds_between(zero_ns, t_ns); }
};

[[nodiscard]] ReportSection path_section(const RunFolder& run);
[[nodiscard]] ReportSection error_section(const RunFolder& run);
/// Relative errors over several lengths; of a run without truth, or that hardly moves, without blocks.
[[nodiscard]] ReportSection distance_section(const RunFolder& run);
/// The same of several runs in one figure, without traces where nothing is known; `id` ends the figure's id.
[[nodiscard]] ReportFigure distance_figure(const std::vector<DrawnRun>& runs, const std::string& id = "");
/// Velocity and biases; without blocks where none is known.
[[nodiscard]] ReportSection motion_section(const RunFolder& run);
/// Velocity errors and biases of runs, with 3 sigma, one over the other; `id` ends the figures' ids.
[[nodiscard]] std::vector<ReportFigure> motion_figures(const std::vector<DrawnRun>& runs,
                                                       const std::string& id = "");
/// Without blocks where the calibration was not watched.
[[nodiscard]] ReportSection calibration_section(const RunFolder& run);
/// What runs estimated of their calibration, three parameters a figure; `id` ends the figures' ids.
[[nodiscard]] std::vector<ReportFigure> estimated_figures(const std::vector<DrawnRun>& runs,
                                                          const std::string& id = "");
/// What the health of runs whose calibration was watched says of rotation and translation of their rigs.
[[nodiscard]] std::vector<ReportFigure> offset_figures(const std::vector<DrawnRun>& runs,
                                                       const std::string& id = "");
/// Without blocks where nothing of the calibration was estimated.
[[nodiscard]] ReportSection estimated_section(const RunFolder& run);
[[nodiscard]] ReportSection innovation_section(const RunFolder& run);
[[nodiscard]] ReportSection point_section(const RunFolder& run);
[[nodiscard]] ReportSection time_section(const RunFolder& run);
[[nodiscard]] ReportSection summary_section(const RunFolder& run);

/// What a page of a run opens on, as summary.json has it; of an older one the verdict alone.
[[nodiscard]] ReportAnswer answer_of(const Json& summary);

/// The main figures, those that are known.
[[nodiscard]] std::vector<ReportFact> lead_facts(const Json& summary);

/// Any JSON value as a reader wants it.
[[nodiscard]] std::string in_words(const Json& value);

/// A figure without curves yet, over seconds since the first frame.
[[nodiscard]] ReportFigure figure_over_time(std::string id, std::string title, std::vector<ReportAxis> y,
                                            std::string caption);

}  // namespace limber::detail
