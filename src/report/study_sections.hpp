// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "limber/report/document.hpp"
#include "limber/report/study_results.hpp"

/// The parts of a study's report.
namespace limber::detail {

/// What the parts of one case's section share.
struct CaseContext {
  const StudyCaseResults& results;
  std::uint64_t seed = 0;
  std::string slug;  ///< begins the ids of its figures
};

/// Mean squared errors with 3 sigma, landmarks, consistency, calibration, path; empty ones are left out.
[[nodiscard]] std::vector<ReportFigure> case_figures(const CaseContext& context);

/// The main figures of all methods in all cases.
[[nodiscard]] ReportTable answer_table(const StudyResults& results);
/// A sentence or two of it about one case.
[[nodiscard]] std::string answer_in_words(const StudyCaseResults& results);
/// Who comes closest, with such sentences about the first few cases.
[[nodiscard]] ReportAnswer study_answer(const StudyResults& results);
inline constexpr std::size_t kCasesInAnswer = 4;

/// All methods of a case.
[[nodiscard]] ReportTable case_table(const StudyCaseResults& results);

/// A line per case and a column per method with position RMSE and ANEES; ekf-full with other walks of theta
/// has tables of its own, one per set of walks. At least one table.
[[nodiscard]] std::vector<ReportTable> overview_tables(const StudyResults& results);

/// Which methods a figure shows at first, and what else it offers.
[[nodiscard]] std::vector<FigureVariant> method_variants(const StudyCaseResults& results);

/// A number to three digits, or a dash.
[[nodiscard]] std::string digits(const std::optional<double>& value);

}  // namespace limber::detail
