// SPDX-License-Identifier: MIT
#include "limber/report/study_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <set>
#include <stdexcept>
#include <utility>

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

ReportFacts case_facts(const StudyCaseResults& results) {
  const Scenario& s = results.info.scenario;
  return {"",
          {{"runs", results.info.finished == results.info.runs
                        ? std::to_string(results.info.runs)
                        : fmt::format("{} of {}", results.info.finished, results.info.runs)},
           {"start", start_in_words(results.info.start)},
           {"duration", fmt::format("{:g} s, stereo at {:g} Hz", s.duration, s.stereo_rate)},
           {"prediction", s.use_imu    ? fmt::format("IMU at {:g} Hz", s.imu_rate)
                          : s.odometry ? std::string("odometry")
                                       : std::string("constant velocity")},
           {"pixel noise", fmt::format("{:g} px", s.noise.pixel)},
           {"points in the world", std::to_string(s.world.points)},
           {"baseline", fmt::format("{:g} m", s.rig.theta.tail<3>().norm())}}};
}

void append(std::vector<ReportBlock>& blocks, const std::vector<ReportBlock>& more) {
  blocks.insert(blocks.end(), more.begin(), more.end());
}

ReportSection case_section(const CaseContext& context, const StudyComments::Case& comments) {
  const StudyCaseResults& results = context.results;
  ReportSection section{context.slug, comments.title.empty() ? results.info.name : comments.title, {}};
  section.blocks.emplace_back(case_facts(results));
  for (ReportFigure& figure : detail::case_figures(context)) {
    section.blocks.emplace_back(std::move(figure));
  }
  section.blocks.emplace_back(detail::case_table(results));
  append(section.blocks, comments.blocks);
  section.blocks.emplace_back(
      ReportListing{"The scenario, every key with its value", results.info.scenario_text});
  return section;
}

ReportSection overview_section(const StudyResults& results, const StudyComments& comments) {
  ReportSection section{"overview", "Overview", comments.overview};
  if (comments.overview.empty()) {
    section.blocks.emplace_back(detail::answer_table(results));
  }
  for (ReportTable& table : detail::overview_tables(results)) {
    section.blocks.emplace_back(std::move(table));
  }
  return section;
}

}  // namespace

ReportDocument study_report(const StudyResults& results, const StudyComments& comments) {
  if (!comments.cases.empty() && comments.cases.size() != results.cases.size()) {
    throw std::invalid_argument(
        fmt::format("study_report: {} cases, comments on {}", results.cases.size(), comments.cases.size()));
  }
  ReportDocument document;
  document.title = comments.title.empty() ? "Monte Carlo study" : comments.title;
  document.subtitle = "Mean over runs; in every run each method sees the same noise";
  document.answer = comments.answer ? *comments.answer : detail::study_answer(results);
  document.facts = {{"cases", std::to_string(results.cases.size())},
                    {"runs", runs_in_words(results)},
                    {"diverged", std::to_string(diverged_runs(results))},
                    {"seed", std::to_string(results.seed)}};
  document.facts.insert(document.facts.end(), comments.facts.begin(), comments.facts.end());
  document.sections.push_back(overview_section(results, comments));
  std::set<std::string> used;
  for (std::size_t k = 0; k < results.cases.size(); ++k) {
    const StudyCaseResults& study_case = results.cases[k];
    document.sections.push_back(
        case_section({study_case, results.seed, slug_of(study_case.info.name, used)},
                     comments.cases.empty() ? StudyComments::Case{} : comments.cases[k]));
  }
  document.sections.insert(document.sections.end(), comments.sections.begin(), comments.sections.end());
  document.footer = "Made by limber " + results.program_version + ".";
  return document;
}

}  // namespace limber
