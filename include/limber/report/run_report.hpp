// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "limber/report/document.hpp"

namespace limber {

/// @brief The report of one run: path, errors with 3 sigma, calibration, innovations, points and time per
/// frame, options.
/// @param folder what write_run_output wrote: trajectory.csv, frames.csv, landmarks.ply, summary.json, and
/// truth.tum, without which nothing is said of errors, and health.csv, without which nothing is said of the
/// calibration
/// @throws DataError if a file is missing or cannot be used
[[nodiscard]] ReportDocument run_report(const std::filesystem::path& folder);

}  // namespace limber
