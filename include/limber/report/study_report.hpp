// SPDX-License-Identifier: MIT
#pragma once

#include "limber/report/document.hpp"
#include "limber/report/study_results.hpp"

namespace limber {

/// @brief The report of a study: for each case mean squared errors with 3 sigma, consistency, calibration and
/// path, with a table of all methods and the scenario; and the paper's claims beside what was measured, for
/// the cases that are the paper's experiment.
[[nodiscard]] ReportDocument study_report(const StudyResults& results);

}  // namespace limber
