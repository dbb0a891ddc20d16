// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

#include "limber/bags/diagnostic.hpp"
#include "limber/bags/write_results.hpp"
#include "limber/run_files/frames_file.hpp"
#include "limber/run_files/health_file.hpp"

/// @file
/// A run's files as what a robot's software shows.
namespace limber {

/// "limber: calibration": the verdict (ok: kOk, degraded: kWarning, decalibrated: kError, cannot tell:
/// kStale), sizes and axes as in health.csv.
[[nodiscard]] Diagnostic calibration_diagnostic(const HealthRow& row);

/// "limber: navigation": kError once the filter has broken down, kWarning where a frame corrected nothing or
/// its inputs are not what they should be.
/// @param is_lost  the filter has broken down in this frame or before
[[nodiscard]] Diagnostic navigation_diagnostic(const FrameRow& row, bool is_lost);

/// Whether a folder holds the results of a finished run.
[[nodiscard]] bool is_run_folder(const std::filesystem::path& folder);

/// @brief The files of a run's folder as results: trajectory, truth where it is known, map, a diagnostic of
/// every frame and of every window of the calibration.
/// @throws DataError if a file is missing or cannot be used
[[nodiscard]] RunResults read_run_results(const std::filesystem::path& folder);

}  // namespace limber
