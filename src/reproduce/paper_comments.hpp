// SPDX-License-Identifier: MIT
#pragma once

#include "limber/report/study_report.hpp"

namespace limber {

/// @brief The paper's claims beside what a study measured, for its report: a verdict on each, and the figures
/// of the paper that a case redraws.
/// @return nothing at all for a study without a case of the paper's experiment
[[nodiscard]] StudyComments paper_comments(const StudyResults& results);

}  // namespace limber
