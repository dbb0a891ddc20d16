// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>

#include "limber/compare/compare_runs.hpp"
#include "limber/report/document.hpp"

namespace limber {

/// @brief The report of several runs: the tables of compare_runs, then, for each recording, paths, errors,
/// relative errors piece by piece and what was found of the calibration, one over the other.
/// @throws as compare_runs
[[nodiscard]] ReportDocument compare_report(std::span<const std::filesystem::path> folders,
                                            const CompareOptions& options = {});

}  // namespace limber
