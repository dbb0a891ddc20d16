// SPDX-License-Identifier: MIT
#include "limber/report/study_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <set>

#include "limber/report/paper_claims.hpp"
#include "limber/study/paper.hpp"
#include "paper_measures.hpp"
#include "study_sections.hpp"

namespace limber {
namespace {

using detail::CaseContext;

/// A name as part of an anchor: letters, digits and single dashes, not in `used`.
std::string slug_of(const std::string& name, std::set<std::string>& used) {
  std::string slug;
  for (const char c : name) {
    const bool plain =
        std::isalnum(static_cast<unsigned char>(c)) != 0 && static_cast<unsigned char>(c) < 128;
    if (plain || (!slug.empty() && slug.back() != '-')) {
      slug += plain ? c : '-';
    }
  }
  std::string unique = "case-" + slug;
  for (int k = 2; !used.insert(unique).second; ++k) {
    unique = fmt::format("case-{}-{}", slug, k);
  }
  return unique;
}

std::uint64_t diverged_runs(const StudyResults& results) {
  std::uint64_t count = 0;
  for (const StudyCaseResults& study_case : results.cases) {
    for (const StudyMethodResults& method : study_case.methods) {
      count += method.summary.diverged;
    }
  }
  return count;
}

std::string runs_in_words(const StudyResults& results) {
  std::uint64_t finished = 0, planned = 0;
  for (const StudyCaseResults& study_case : results.cases) {
    finished += study_case.info.finished * study_case.methods.size();
    planned += study_case.info.runs * study_case.methods.size();
  }
  return finished == planned ? std::to_string(finished) : fmt::format("{} of {}", finished, planned);
}

std::size_t count(const std::vector<PaperClaim>& claims, Verdict verdict) {
  return static_cast<std::size_t>(std::count_if(
      claims.begin(), claims.end(), [verdict](const PaperClaim& c) { return c.claim.verdict == verdict; }));
}

bool has_paper_case(const StudyResults& results) {
  return std::any_of(results.cases.begin(), results.cases.end(),
                     [](const auto& c) { return paper_case_of(c.info.scenario).has_value(); });
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

ReportFacts case_facts(const StudyCaseResults& results) {
  const Scenario& s = results.info.scenario;
  return {"",
          {{"runs", results.info.finished == results.info.runs
                        ? std::to_string(results.info.runs)
                        : fmt::format("{} of {}", results.info.finished, results.info.runs)},
           {"duration", fmt::format("{:g} s, stereo at {:g} Hz", s.duration, s.stereo_rate)},
           {"prediction", s.use_imu    ? fmt::format("IMU at {:g} Hz", s.imu_rate)
                          : s.odometry ? std::string("odometry")
                                       : std::string("constant velocity")},
           {"pixel noise", fmt::format("{:g} px", s.noise.pixel)},
           {"points in the world", std::to_string(s.world.points)},
           {"baseline", fmt::format("{:g} m", s.rig.theta.tail<3>().norm())}}};
}

std::string section_title(const StudyCaseInfo& info, const std::optional<PaperCase>& paper_case) {
  if (!paper_case) {
    return info.name;
  }
  const std::string figures = paper_figures_of(info.name);
  return fmt::format("{}{}case {} ({})", figures, figures.empty() ? "" : ": ", to_string(*paper_case),
                     info.name);
}

/// `about`: the claims that speak of this case; none where another case of the study stands for it.
ReportSection case_section(const CaseContext& context, const std::optional<PaperCase>& paper_case,
                           ReportClaims about) {
  const StudyCaseResults& results = context.results;
  ReportSection section{context.slug, section_title(results.info, paper_case), {}};
  section.blocks.emplace_back(case_facts(results));
  for (ReportFigure& figure : detail::case_figures(context)) {
    section.blocks.emplace_back(std::move(figure));
  }
  section.blocks.emplace_back(detail::case_table(results));
  if (!about.claims.empty()) {
    section.blocks.emplace_back(std::move(about));
  }
  section.blocks.emplace_back(
      ReportListing{"The scenario, every key with its value", results.info.scenario_text});
  return section;
}

ReportSection overview_section(const StudyResults& results, const std::vector<PaperClaim>& claims) {
  ReportSection section{"overview", "Overview", {}};
  for (ReportTable& table : detail::overview_tables(results)) {
    section.blocks.emplace_back(std::move(table));
  }
  if (!claims.empty()) {
    section.blocks.emplace_back(verdicts(claims));
    section.blocks.emplace_back(
        ReportText{"What was measured, and the rule that decides, stand with each case below and, for claims "
                   "about several cases, under the last heading."});
  }
  return section;
}

}  // namespace

ReportDocument study_report(const StudyResults& results) {
  const std::vector<PaperClaim> claims =
      has_paper_case(results) ? paper_claims(results) : std::vector<PaperClaim>{};
  ReportDocument document;
  document.title = claims.empty() ? "Monte Carlo study" : "The paper's experiment";
  document.subtitle = "Mean over runs; in every run each method sees the same noise";
  document.facts = {{"cases", std::to_string(results.cases.size())},
                    {"runs", runs_in_words(results)},
                    {"diverged", std::to_string(diverged_runs(results))},
                    {"seed", std::to_string(results.seed)}};
  if (!claims.empty()) {
    document.facts.push_back({"claims that agree", std::to_string(count(claims, Verdict::kAgrees))});
    document.facts.push_back({"that do not", std::to_string(count(claims, Verdict::kDisagrees))});
    document.facts.push_back({"not measured", std::to_string(count(claims, Verdict::kNotMeasured))});
  }
  document.sections.push_back(overview_section(results, claims));
  const detail::PaperStudy study(results);
  std::set<std::string> used;
  for (std::size_t k = 0; k < results.cases.size(); ++k) {
    const StudyCaseResults& study_case = results.cases[k];
    const std::optional<PaperCase>& paper_case = study.cases[k];
    const bool is_meant = paper_case && find_case(study, *paper_case) == &study_case;
    document.sections.push_back(case_section({study_case, results.seed, slug_of(study_case.info.name, used)},
                                             paper_case,
                                             is_meant ? claims_about(claims, paper_case) : ReportClaims{}));
  }
  if (!claims.empty()) {
    document.sections.push_back({"claims", "Claims across cases", {claims_about(claims, std::nullopt)}});
  }
  document.footer = "Made by limber " + results.program_version + ".";
  return document;
}

}  // namespace limber
