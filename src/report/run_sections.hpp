// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <string>
#include <vector>

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

  [[nodiscard]] double seconds(std::int64_t t_ns) const { return 1e-9 * static_cast<double>(t_ns - zero_ns); }
};

[[nodiscard]] ReportSection path_section(const RunFolder& run);
[[nodiscard]] ReportSection error_section(const RunFolder& run);
/// Of a run whose calibration was watched.
[[nodiscard]] ReportSection calibration_section(const RunFolder& run);
/// What runs estimated of their calibration, three parameters a figure; `id` ends the figures' ids.
[[nodiscard]] std::vector<ReportFigure> estimated_figures(const std::vector<DrawnRun>& runs,
                                                          const std::string& id = "");
/// What the health of runs whose calibration was watched says of rotation and translation of their rigs.
[[nodiscard]] std::vector<ReportFigure> offset_figures(const std::vector<DrawnRun>& runs,
                                                       const std::string& id = "");
/// Of a run that estimated something of its calibration.
[[nodiscard]] ReportSection estimated_section(const RunFolder& run);
[[nodiscard]] ReportSection innovation_section(const RunFolder& run);
[[nodiscard]] ReportSection point_section(const RunFolder& run);
[[nodiscard]] ReportSection time_section(const RunFolder& run);
[[nodiscard]] ReportSection summary_section(const RunFolder& run);

/// What a reader wants to know first.
[[nodiscard]] std::vector<ReportFact> lead_facts(const Json& summary);

/// Any JSON value as a reader wants it.
[[nodiscard]] std::string in_words(const Json& value);

/// A figure without curves yet, over seconds since the first frame.
[[nodiscard]] ReportFigure figure_over_time(std::string id, std::string title, std::vector<ReportAxis> y,
                                            std::string caption);

}  // namespace limber::detail
