// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "limber/compare/compare_runs.hpp"
#include "run_sections.hpp"

/// The sections of a report of several runs.
namespace limber::detail {

/// The runs of one recording, the first of which the others are compared with.
struct RunGroup {
  std::string id;  ///< ends the anchors of what is drawn of it: unique in the document
  std::vector<DrawnRun> runs;
  std::vector<const ComparedRun*> compared;  ///< of the same runs
  [[nodiscard]] const RunFolder& first() const { return *runs.front().run; }
  /// The truth of all is known.
  [[nodiscard]] bool has_truth() const;
  /// The world of the truth is not level.
  [[nodiscard]] bool tilted() const;
};

[[nodiscard]] ReportSection comparison_section(const RunComparison& comparison);
[[nodiscard]] ReportSection paths_section(const RunGroup& group);
/// Position and attitude error over time, and relative errors; without truth the distance to the first run.
[[nodiscard]] ReportSection errors_section(const RunGroup& group);
/// Velocity and biases. May be without blocks.
[[nodiscard]] ReportSection states_section(const RunGroup& group);
/// What the runs estimated of the calibration, and what their health says of it. May be without blocks.
[[nodiscard]] ReportSection calibrations_section(const RunGroup& group);

/// What takes a run's poses to the world in which its group is drawn: that of the first run's truth, after a
/// rigid fit; without truth, of the first run, by position and yaw of their first common pose.
[[nodiscard]] Pose drawn_alignment(const RunGroup& group, std::size_t run);

}  // namespace limber::detail
