// SPDX-License-Identifier: MIT
#include "reproduce/paper_comments.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

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

bool is_judged(const PaperClaim& claim) { return claim.claim.verdict != Verdict::kNotMeasured; }

/// Every claim that was judged, in a line: what a reader looks for first.
ReportClaims verdicts(const std::vector<PaperClaim>& claims) {
  ReportClaims out{"The paper's claims at a glance", {}, true};
  for (const PaperClaim& claim : claims) {
    if (is_judged(claim)) {
      out.claims.push_back(claim.claim);
    }
  }
  return out;
}

/// The claims that this study cannot judge, behind a line that opens them.
ReportListing left_out(const std::vector<PaperClaim>& claims) {
  ReportListing out{fmt::format("{} claims of the paper are about what this study does not hold",
                                count(claims, Verdict::kNotMeasured)),
                    ""};
  for (const PaperClaim& claim : claims) {
    if (!is_judged(claim)) {
      out.text +=
          fmt::format("{}\n  {}: {}\n", claim.claim.statement, claim.claim.source, claim.claim.measured);
    }
  }
  return out;
}

ReportAnswer answer_of(const std::vector<PaperClaim>& claims) {
  const std::size_t agree = count(claims, Verdict::kAgrees), disagree = count(claims, Verdict::kDisagrees),
                    open = count(claims, Verdict::kNotMeasured);
  ReportAnswer out;
  if (agree + disagree == 0) {
    out.headline = "No claim of the paper can be judged by this study";
  } else {
    out.headline = fmt::format("{} of the {} claims of the paper that this study can judge agree", agree,
                               agree + disagree);
  }
  if (open > 0) {
    out.sentences.push_back(fmt::format(
        "{} others are about what it does not hold: limber paper without --figure measures all.", open));
  }
  return out;
}

/// Judged claims that speak of this case alone; of several: `across`.
ReportClaims claims_about(const std::vector<PaperClaim>& claims, const std::optional<PaperCase>& paper_case) {
  ReportClaims out{"What the paper claims, and what was measured", {}, false};
  for (const PaperClaim& claim : claims) {
    const bool is_about_one = claim.cases.size() == 1;
    if (is_judged(claim) &&
        (paper_case ? is_about_one && claim.cases.front() == *paper_case : !is_about_one)) {
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
  out.answer = answer_of(claims);
  out.facts = {{"claims that agree", std::to_string(count(claims, Verdict::kAgrees))},
               {"that do not", std::to_string(count(claims, Verdict::kDisagrees))}};
  ReportClaims judged = verdicts(claims);
  if (!judged.claims.empty()) {
    out.overview = {std::move(judged),
                    ReportText{"What was measured, and the rule that decides, stand with the cases below."}};
  }
  if (count(claims, Verdict::kNotMeasured) > 0) {
    out.overview.emplace_back(left_out(claims));
  }
  const detail::PaperStudy study(results);
  for (std::size_t k = 0; k < results.cases.size(); ++k) {
    out.cases.push_back(case_comments(study, k, claims));
  }
  if (ReportClaims across = claims_about(claims, std::nullopt); !across.claims.empty()) {
    out.sections = {{"claims", "Claims across cases", {std::move(across)}}};
  }
  return out;
}

}  // namespace limber
