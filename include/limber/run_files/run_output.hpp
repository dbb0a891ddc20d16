// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "limber/diagnose/run_summary.hpp"
#include "limber/run/run_recording.hpp"

namespace limber {

/// Names of all files that write_run_output may make.
[[nodiscard]] const std::vector<std::string>& run_file_names();

/// The text of summary.json: docs/formats-results.md.
[[nodiscard]] std::string summary_json(const RunOptions& options, const RunRecord& record,
                                       const RunSummary& summary);

/// @brief Writes trajectory.tum, trajectory.csv, truth.tum (where the truth is known), truth.csv
/// (where it has velocity or biases), landmarks.ply,
/// frames.csv, health.csv (where the calibration was watched), calibration.csv (where it was estimated),
/// refusals.csv and summary.json: all of them or
/// none; a folder without summary.json holds no finished run. `folder` is made if needed.
/// @throws DataError if the folder cannot be written
void write_run_output(const std::filesystem::path& folder, const RunOptions& options, const RunRecord& record,
                      const RunSummary& summary);

}  // namespace limber
