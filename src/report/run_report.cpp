// SPDX-License-Identifier: MIT
#include "limber/report/run_report.hpp"

#include <fmt/format.h>

#include "run_sections.hpp"

namespace limber {

ReportDocument run_report(const std::filesystem::path& folder) {
  const detail::RunFolder run = detail::read_run_folder(folder);
  ReportDocument document;
  document.title = fmt::format("{} on {}", run.method,
                               detail::in_words(run.summary.value("dataset", detail::Json("a recording"))));
  document.subtitle =
      fmt::format("One run: {} frames in {:.1f} s", run.frames.size(), run.seconds(run.frames.back().t_ns));
  document.facts = detail::lead_facts(run.summary);
  document.sections = {detail::path_section(run),       detail::error_section(run),
                       detail::innovation_section(run), detail::point_section(run),
                       detail::time_section(run),       detail::summary_section(run)};
  if (!run.calibration.empty()) {
    document.sections.insert(document.sections.begin() + 2, detail::estimated_section(run));
  }
  if (!run.health.empty()) {
    document.sections.insert(document.sections.begin() + 2, detail::calibration_section(run));
  }
  document.footer = "Made by limber report from the files beside it.";
  return document;
}

}  // namespace limber
