// SPDX-License-Identifier: MIT
#include "limber/report/compare_report.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "compare/compare_folders.hpp"
#include "compare_sections.hpp"

namespace limber {
namespace detail {
namespace {

/// Colour by method; runs of the same method have dashes of their own.
std::string style_of(const ComparedRun& run, const RunGroup& group) {
  const bool taken = std::any_of(group.compared.begin(), group.compared.end(),
                                 [&](const ComparedRun* other) { return other->method == run.method; });
  return taken ? run.method + ":" + run.label : run.method;
}

void join(const RunFolder& folder, const ComparedRun& run, RunGroup& group) {
  const std::int64_t zero_ns =
      group.runs.empty() ? folder.trajectory.front().t_ns : group.first().trajectory.front().t_ns;
  group.runs.push_back({&folder, run.label, style_of(run, group), zero_ns});
  group.compared.push_back(&run);
}

std::vector<RunGroup> groups_of(const std::vector<RunFolder>& folders, const RunComparison& comparison) {
  std::vector<RunGroup> groups;
  std::vector<std::size_t> group_of(folders.size());
  for (std::size_t k = 0; k < folders.size(); ++k) {
    const auto difference = std::find_if(comparison.differences.begin(), comparison.differences.end(),
                                         [k](const RunDifference& candidate) { return candidate.run == k; });
    if (difference == comparison.differences.end()) {
      groups.push_back({groups.empty() ? "" : fmt::format("-{}", groups.size() + 1), {}, {}});
      group_of[k] = groups.size() - 1;
    } else {
      group_of[k] = group_of[difference->against];
    }
    join(folders[k], comparison.runs[k], groups[group_of[k]]);
  }
  return groups;
}

/// Each run of a group against the first, as far as there is more to say than a distance.
void add_differences(const RunComparison& comparison, std::vector<std::string>& out) {
  for (const RunDifference& difference : comparison.differences) {
    const std::string &run = comparison.runs[difference.run].label,
                      &against = comparison.runs[difference.against].label;
    out.push_back(
        difference.rpe_percent
            ? fmt::format("Relative error of {} minus that of {}, in % of the distance: {}.", run, against,
                          difference_in_words(*difference.rpe_percent))
            : fmt::format("At the end {} is {:.3g} m from {}.", run, difference.apart_end_m, against));
  }
}

/// Which run of a recording comes closest to the truth, and how close.
std::string closest_of(const RunGroup& group) {
  if (!group.has_truth()) {
    return "no truth is known";
  }
  const auto best = std::min_element(group.compared.begin(), group.compared.end(),
                                     [](const ComparedRun* a, const ComparedRun* b) {
                                       return *a->ate_m < *b->ate_m;  // known, as the truth is
                                     });
  return fmt::format("{}, {:.3g} m (ATE)", (*best)->label, *(*best)->ate_m);
}

ReportAnswer comparison_answer(const RunComparison& comparison, const std::vector<RunGroup>& groups) {
  ReportAnswer out;
  out.headline = "Closest to the truth";
  if (groups.size() == 1) {
    out.headline += ": " + closest_of(groups.front());
  } else {
    for (const RunGroup& group : groups) {
      out.sentences.push_back(
          fmt::format("On {}: {}.", group.compared.front()->recording, closest_of(group)));
    }
  }
  add_differences(comparison, out.sentences);
  return out;
}

/// The main figures of each run.
std::vector<ReportFact> facts_of(const RunComparison& comparison) {
  std::vector<ReportFact> facts;
  for (const ComparedRun& run : comparison.runs) {
    std::string value = run.ate_m ? fmt::format("{:.3g} m", *run.ate_m) : "no truth";
    value += run.anees ? fmt::format(", ANEES {:.3g}", *run.anees) : "";
    value += run.end == RunEnd::kDone ? "" : ", " + to_string(run.end);
    facts.push_back({run.label + (run.ate_m ? ", ATE" : ""), value});
  }
  return facts;
}

std::string names_of(const std::vector<RunGroup>& groups) {
  std::string names;
  for (const RunGroup& group : groups) {
    names += (names.empty() ? "" : ", ") + group.compared.front()->recording;
  }
  return names;
}

void add_sections(const RunGroup& group, bool only, ReportDocument& document) {
  for (ReportSection section :
       {paths_section(group), errors_section(group), states_section(group), calibrations_section(group)}) {
    if (!section.blocks.empty()) {
      section.id += group.id;
      section.title += only ? "" : " on " + group.compared.front()->recording;
      document.sections.push_back(std::move(section));
    }
  }
}

}  // namespace

bool RunGroup::has_truth() const {
  return std::all_of(compared.begin(), compared.end(), [](const ComparedRun* run) { return run->has_truth; });
}

bool RunGroup::tilted() const {
  return std::any_of(compared.begin(), compared.end(),
                     [](const ComparedRun* run) { return run->truth_is_tilted; });
}

}  // namespace detail

ReportDocument compare_report(std::span<const std::filesystem::path> folders, const CompareOptions& options) {
  const std::vector<detail::RunFolder> runs = detail::read_run_folders(folders);
  const RunComparison comparison = detail::compare_folders(runs, options);
  const std::vector<detail::RunGroup> groups = detail::groups_of(runs, comparison);
  ReportDocument document;
  document.title =
      fmt::format("{} run{} on {}", runs.size(), runs.size() == 1 ? "" : "s", detail::names_of(groups));
  document.subtitle = fmt::format("The first run of a recording is what its others are compared with: {}",
                                  comparison.runs.front().label);
  document.answer = detail::comparison_answer(comparison, groups);
  document.facts = detail::facts_of(comparison);
  document.sections.push_back(detail::comparison_section(comparison));
  for (const detail::RunGroup& group : groups) {
    detail::add_sections(group, groups.size() == 1, document);
  }
  document.footer = "Made by limber compare from the folders of the runs.";
  return document;
}

}  // namespace limber
