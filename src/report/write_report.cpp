// SPDX-License-Identifier: MIT
#include "limber/report/write_report.hpp"

#include <stdexcept>
#include <string_view>

#include "limber/io/atomic_file.hpp"
#include "page_template.hpp"

namespace limber {
namespace {

std::string replace_each(std::string_view text, std::string_view characters,
                         std::string (*replacement)(char)) {
  std::string out;
  for (const char c : text) {
    out += characters.find(c) == std::string_view::npos ? std::string(1, c) : replacement(c);
  }
  return out;
}

std::string as_html(std::string_view text) {
  return replace_each(text, "&<>", [](char c) -> std::string {
    return c == '&' ? "&amp;" : c == '<' ? "&lt;" : "&gt;";
  });
}

/// No "</script>" or "<!--" can end the element that holds the data.
std::string as_script_data(std::string_view json) {
  return replace_each(json, "<", [](char) -> std::string { return "\\u003c"; });
}

}  // namespace

bool can_write_reports() { return !detail::page_template().empty(); }

std::string why_no_reports() {
  return can_write_reports() ? ""
                             : "this program was built without the report page; install nodejs and npm, and "
                               "configure it again with -DLIMBER_WITH_REPORT=ON";
}

void write_report(const ReportDocument& document, const std::filesystem::path& path) {
  if (!can_write_reports()) {
    throw std::runtime_error("cannot write " + path.string() + ": " + why_no_reports());
  }
  const std::string_view page = detail::page_template();
  const std::size_t title = page.find(detail::kTitlePlace);
  const std::size_t after_title = title + detail::kTitlePlace.size();
  const std::size_t data = page.find(detail::kDataPlace, after_title);
  const std::string json = as_script_data(report_json(document));
  AtomicFile file(path);
  file.write(page.substr(0, title));
  file.write(as_html(document.title));
  file.write(page.substr(after_title, data - after_title));
  file.write(json);
  file.write(page.substr(data + detail::kDataPlace.size()));
  file.commit();
}

}  // namespace limber
