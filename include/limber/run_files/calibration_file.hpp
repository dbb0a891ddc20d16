// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "limber/run/run_recording.hpp"

namespace limber {

/// @brief Writes calibration.csv: for every parameter true minus assumed and the standard deviation of that;
/// degrees, metres, pixels, seconds; cells of what is not estimated are empty. Columns:
/// docs/formats-results.md.
/// @throws DataError if the file cannot be written
void write_calibration_csv(const std::filesystem::path& path, const std::vector<CalibrationRow>& rows);

/// @throws DataError if the file cannot be used
[[nodiscard]] std::vector<CalibrationRow> read_calibration_csv(const std::filesystem::path& path);

}  // namespace limber
