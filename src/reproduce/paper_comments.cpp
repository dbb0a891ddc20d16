// SPDX-License-Identifier: MIT
#include "reproduce/paper_comments.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "reproduce/paper_claims.hpp"
#include "reproduce/paper_measures.hpp"
#include "reproduce/paper_plan.hpp"

namespace limber {
namespace {

std::size_t count(const std::vector<PaperClaim>& claims, Verdict verdict) {
  return static_cast<std::size_t>(std::count_if(
      claims.begin(), claims.end(), [verdict](const PaperClaim& c) { return c.claim.verdict == verdict; }));
}

bool has_paper_case(const StudyResults& results) {
  return std::any_of(results.cases.begin(), results.cases.end(),
                     [](const auto& c) { return paper_case_of(c.info).has_value(); });
}

/// Every claim in a line: what a reader looks for first.
ReportClaims verdicts(const std::vector<PaperClaim>& claims) {
  ReportClaims out{"The paper's claims at a glance", {}, true};
  for (const PaperClaim& claim : claims) {
    out.claims.push_back(claim.claim);
  }
  return out;
}

/// Claims that speak of this case alone; of several: `across`.
ReportClaims claims_about(const std::vector<PaperClaim>& claims, const std::optional<PaperCase>& paper_case) {
  ReportClaims out{"What the paper claims, and what was measured", {}, false};
  for (const PaperClaim& claim : claims) {
    const bool is_about_one = claim.cases.size() == 1;
    if (paper_case ? is_about_one && claim.cases.front() == *paper_case : !is_about_one) {
      out.claims.push_back(claim.claim);
    }
  }
  return out;
}

std::string section_title(const StudyCaseInfo& info, const std::optional<PaperCase>& paper_case) {
  if (!paper_case) {
    return info.name;
  }
  const std::string figures = paper_figures_of(info.name);
  return fmt::format("{}{}case {} ({})", figures, figures.empty() ? "" : ": ", to_string(*paper_case),
                     info.name);
}

/// Claims stand with the case that they are decided on; another case of the same kind has none.
StudyComments::Case case_comments(const detail::PaperStudy& study, std::size_t k,
                                  const std::vector<PaperClaim>& claims) {
  const StudyCaseResults& study_case = study.results.cases[k];
  const std::optional<PaperCase>& paper_case = study.cases[k];
  StudyComments::Case out{section_title(study_case.info, paper_case), {}};
  if (paper_case && find_case(study, *paper_case) == &study_case) {
    ReportClaims about = claims_about(claims, paper_case);
    if (!about.claims.empty()) {
      out.blocks.emplace_back(std::move(about));
    }
  }
  return out;
}

}  // namespace

StudyComments paper_comments(const StudyResults& results) {
  if (!has_paper_case(results)) {
    return {};
  }
  const std::vector<PaperClaim> claims = paper_claims(results);
  StudyComments out;
  out.title = "The paper's experiment";
  out.facts = {{"claims that agree", std::to_string(count(claims, Verdict::kAgrees))},
               {"that do not", std::to_string(count(claims, Verdict::kDisagrees))},
               {"not measured", std::to_string(count(claims, Verdict::kNotMeasured))}};
  out.overview = {
      verdicts(claims),
      ReportText{"What was measured, and the rule that decides, stand with each case below and, for claims "
                 "about several cases, under the last heading."}};
  const detail::PaperStudy study(results);
  for (std::size_t k = 0; k < results.cases.size(); ++k) {
    out.cases.push_back(case_comments(study, k, claims));
  }
  out.sections = {{"claims", "Claims across cases", {claims_about(claims, std::nullopt)}}};
  return out;
}

}  // namespace limber
