// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

#include "limber/report/document.hpp"

namespace limber {

/// Largest number of points drawn of one trace; longer ones are thinned, and the figure says so.
inline constexpr std::size_t kMaxCurvePoints = 2000;
inline constexpr std::size_t kMaxPathPoints = 4000;  ///< of kTopView and kSpace

/// @brief The document as the JSON that the page draws. Long traces are thinned; series are 32-bit floats in
/// base64, equal ones stored once, and figures refer to them by index. docs/report.md lists the keys.
/// @throws std::invalid_argument if ids repeat, a trace's lengths differ, its panel does not exist, or a
/// table's row is not as long as its head
[[nodiscard]] std::string report_json(const ReportDocument& document);

/// Whether this build carries the page (see LIMBER_WITH_REPORT): without it no report can be written.
[[nodiscard]] bool can_write_reports();

/// Why can_write_reports() is false and what to do about it, in plain words.
[[nodiscard]] std::string why_no_reports();

/// @brief Writes one HTML file that holds everything it needs: page, style, Plotly.js and data. Whole or not
/// at all.
/// @throws std::runtime_error unless can_write_reports()
/// @throws std::invalid_argument as report_json
/// @throws DataError if the file cannot be written
void write_report(const ReportDocument& document, const std::filesystem::path& path);

}  // namespace limber
