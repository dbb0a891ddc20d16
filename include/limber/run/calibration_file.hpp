// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "limber/navigate/navigator.hpp"

namespace limber {

/// What a filter took for the calibration after a frame.
struct CalibrationRow {
  std::int64_t t_ns = 0;
  CalibrationEstimate estimate;
};

/// @brief Writes calibration.csv: for every parameter true minus assumed and the standard deviation of that;
/// degrees, metres, pixels, seconds; cells of what is not estimated are empty. Columns: docs/formats.md.
/// @throws DataError if the file cannot be written
void write_calibration_csv(const std::filesystem::path& path, const std::vector<CalibrationRow>& rows);

/// @throws DataError if the file cannot be used
[[nodiscard]] std::vector<CalibrationRow> read_calibration_csv(const std::filesystem::path& path);

}  // namespace limber
