// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "limber/report/document.hpp"
#include "limber/report/study_results.hpp"

namespace limber {

/// What somebody who knows the experiment behind a study adds to its report.
struct StudyComments {
  /// What is added to one case.
  struct Case {
    std::string title;                ///< of the case's section; empty: its name
    std::vector<ReportBlock> blocks;  ///< below the case's table
  };
  std::string title;                    ///< of the page; empty: "Monte Carlo study"
  std::optional<ReportAnswer> answer;   ///< in the place of the study's own
  std::vector<ReportFact> facts;        ///< after the study's own
  std::vector<ReportBlock> overview;    ///< above the overview's tables
  std::vector<Case> cases;              ///< one per case of the study, or none at all
  std::vector<ReportSection> sections;  ///< at the end
};

/// @brief The report of a study: for each case mean squared errors with 3 sigma, consistency, calibration and
/// path, with a table of all methods and the scenario; and what `comments` add.
/// @throws std::invalid_argument if comments.cases is neither empty nor one per case
[[nodiscard]] ReportDocument study_report(const StudyResults& results, const StudyComments& comments = {});

}  // namespace limber
