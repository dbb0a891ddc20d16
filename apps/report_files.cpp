// SPDX-License-Identifier: MIT
#include "report_files.hpp"

#include <system_error>

#include "limber/report/run_report.hpp"
#include "limber/report/study_report.hpp"
#include "limber/report/write_report.hpp"
#include "messages.hpp"
#include "reproduce/paper_comments.hpp"

namespace limber::app {

namespace fs = std::filesystem;

namespace {

ReportDocument report_of_study(const fs::path& database) {
  const StudyResults results = load_study(database);
  return study_report(results, paper_comments(results));
}

}  // namespace

void make_report(const fs::path& results, const fs::path& page) {
  write_report(fs::is_directory(results) ? run_report(results) : report_of_study(results), page);
}

void make_report_beside(const fs::path& results) {
  const fs::path page = default_report_path(results);
  std::error_code ignored;
  fs::remove(page, ignored);
  if (!can_write_reports()) {
    print_note("the report is left out: " + why_no_reports());
    return;
  }
  make_report(results, page);
  print_note("written: " + page.string());
}

}  // namespace limber::app
