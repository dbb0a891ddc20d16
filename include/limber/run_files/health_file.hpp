// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "limber/navigate/navigator.hpp"

namespace limber {

/// @brief Writes health.csv: a row per frame that has a health report; angles in degrees, lengths in mm.
/// Columns: docs/formats.md.
/// @throws DataError if the file cannot be written
void write_health_csv(const std::filesystem::path& path, std::span<const FrameReport> frames);

/// @throws DataError if the file cannot be used
[[nodiscard]] std::vector<HealthReport> read_health_csv(const std::filesystem::path& path);

}  // namespace limber
