// SPDX-License-Identifier: MIT
// What a study says at a glance.
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <utility>

#include "study_sections.hpp"

namespace limber::detail {
namespace {

std::vector<BriefRow> brief_of(const StudyCaseResults& results) {
  std::vector<MethodSummary> summaries;
  for (const StudyMethodResults& method : results.methods) {
    summaries.push_back(method.summary);
  }
  return brief_rows(summaries);
}

/// Empty: no run is finished.
std::string best_of(const StudyCaseResults& results) {
  for (const BriefRow& row : brief_of(results)) {
    if (row.is_best) {
      return row.label;
    }
  }
  return {};
}

/// The method that is best in most cases, and in how many.
std::string headline_of(const StudyResults& results) {
  std::map<std::string, std::size_t> wins;
  for (const StudyCaseResults& study_case : results.cases) {
    if (const std::string best = best_of(study_case); !best.empty()) {
      ++wins[best];
    }
  }
  if (wins.empty()) {
    return "No run is finished";
  }
  const auto most = std::max_element(wins.begin(), wins.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  return results.cases.size() == 1 ? "Closest to the truth: " + most->first
                                   : fmt::format("Closest to the truth in {} of {} cases: {}", most->second,
                                                 results.cases.size(), most->first);
}

}  // namespace

std::string answer_in_words(const StudyCaseResults& results) {
  const std::string best = best_of(results);
  if (best.empty()) {
    return results.info.name + ": no run is finished.";
  }
  std::string sure;
  for (const BriefRow& row : brief_of(results)) {
    if (row.is_overconfident) {
      sure += (sure.empty() ? "" : ", ") + row.label + " (" + row.to_claimed + ")";
    }
  }
  return fmt::format("{} ({} rig), started {}: {} comes closest. {}", results.info.name,
                     results.info.scenario.decalibration.empty() ? "sound" : "bent",
                     start_in_words(results.info.start), best,
                     sure.empty() ? "No filter is more than twice as wrong as it claims."
                                  : "More than twice as wrong as they claim: " + sure + ".");
}

ReportAnswer study_answer(const StudyResults& results) {
  ReportAnswer out;
  out.headline = headline_of(results);
  const auto shown = static_cast<std::ptrdiff_t>(std::min(results.cases.size(), kCasesInAnswer));
  std::transform(results.cases.begin(), results.cases.begin() + shown, std::back_inserter(out.sentences),
                 answer_in_words);
  if (results.cases.size() > kCasesInAnswer) {
    out.sentences.push_back(
        fmt::format("{} more cases in the table below.", results.cases.size() - kCasesInAnswer));
  }
  return out;
}

}  // namespace limber::detail
