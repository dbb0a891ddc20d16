// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

/// Results become a page: what `limber report` does, and other commands at their end.
namespace limber::app {

/// Where the page of results goes unless the user says otherwise: report.html in the folder of a run,
/// study.html beside study.sqlite.
[[nodiscard]] inline std::filesystem::path default_report_path(const std::filesystem::path& results) {
  return std::filesystem::is_directory(results) ? results / "report.html"
                                                : std::filesystem::path(results).replace_extension(".html");
}

/// @param results folder of a run, or database of a study
/// @throws DataError if they cannot be read or the page cannot be written
/// @throws std::runtime_error if this program was built without the page
void make_report(const std::filesystem::path& results, const std::filesystem::path& page);

/// The page at its default place, instead of an older one, and a note that says so. A program built without
/// the page says that instead.
void make_report_beside(const std::filesystem::path& results);

}  // namespace limber::app
