// SPDX-License-Identifier: MIT
#include "limber/report/run_report.hpp"

#include <fmt/format.h>

#include <utility>

#include "run_sections.hpp"

namespace limber {

ReportDocument run_report(const std::filesystem::path& folder) {
  const detail::RunFolder run = detail::read_run_folder(folder);
  ReportDocument document;
  document.title = fmt::format("{} on {}", run.method,
                               detail::in_words(run.summary.value("dataset", detail::Json("a recording"))));
  document.subtitle =
      fmt::format("One run: {} frames in {:.1f} s", run.frames.size(), run.seconds(run.frames.back().t_ns));
  document.answer = detail::answer_of(run.summary);
  document.facts = detail::lead_facts(run.summary);
  for (ReportSection section :
       {detail::path_section(run), detail::error_section(run), detail::distance_section(run),
        detail::motion_section(run), detail::calibration_section(run), detail::estimated_section(run),
        detail::innovation_section(run), detail::point_section(run), detail::time_section(run),
        detail::summary_section(run)}) {
    if (!section.blocks.empty()) {
      document.sections.push_back(std::move(section));
    }
  }
  document.footer = "Made by limber report from the files beside it.";
  return document;
}

}  // namespace limber
