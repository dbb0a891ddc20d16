// SPDX-License-Identifier: MIT
#include "replaceable.hpp"

#include <algorithm>
#include <fstream>
#include <string>
#include <system_error>

#include "limber/core/errors.hpp"
#include "limber/run_files/run_output.hpp"
#include "report_files.hpp"

namespace limber::app {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMarkWithin = 16'384;  // [bytes] from the beginning of the file

bool bears(const fs::path& file, std::string_view mark) {
  std::ifstream stream(file, std::ios::binary);
  std::string beginning(kMarkWithin, '\0');
  stream.read(beginning.data(), static_cast<std::streamsize>(beginning.size()));
  beginning.resize(static_cast<std::size_t>(stream.gcount()));
  return beginning.find(mark) != std::string::npos;
}

void require_regular(const fs::path& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw DataError(file.string(), 0, "a regular file to replace, or none",
                    fs::is_directory(status) ? "a folder" : "a device, a pipe or the like");
  }
}

[[noreturn]] void refuse(const fs::path& file, bool has_mark = true) {
  throw DataError(file.string(), 0,
                  has_mark ? "no file of this name, or one that limber wrote" : "no file of this name",
                  has_mark ? "another one; --force replaces it" : "one; --force replaces it");
}

/// A file of this name, if it exists, lies within the folder, seen through links.
bool lies_within(const fs::path& file, const fs::path& folder) {
  std::error_code error;
  const fs::path inner = fs::weakly_canonical(file, error), outer = fs::weakly_canonical(folder, error);
  return std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first == outer.end();
}

}  // namespace

void require_replaceable(const fs::path& file, std::string_view mark, bool force,
                         const std::vector<fs::path>& inputs) {
  require_regular(file);
  if (!fs::exists(file)) {
    return;
  }
  const bool own = fs::file_size(file) == 0 || (mark != kNoMark && bears(file, mark));
  for (const fs::path& input : inputs) {
    std::error_code ignored;
    if (fs::equivalent(file, input, ignored) ||
        (!own && fs::is_directory(input) && lies_within(file, input))) {
      throw DataError(file.string(), 0, "a name for the result that is not also an input",
                      "what this command reads");
    }
  }
  if (!own && !force) {
    refuse(file, mark != kNoMark);
  }
}

void require_replaceable_run(const fs::path& folder, bool force) {
  std::string foreign;
  for (const std::string& name : run_file_names()) {
    require_regular(folder / name);
    if (fs::exists(folder / name) && foreign.empty()) {
      foreign = name;
    }
  }
  const bool own = fs::exists(folder / "summary.json") && bears(folder / "summary.json", kRunMark);
  if (!foreign.empty() && !own && !force) {
    refuse(folder / foreign);
  }
  require_replaceable(folder / "report.html", kPageMark, force);
}

void require_replaceable_export(const fs::path& database, std::string_view format, bool force) {
  const auto beside = [&](const char* ending) {
    return database.parent_path() / (database.stem().string() + ending);
  };
  if (format == "csv") {
    require_replaceable(beside("_runs.csv"), kRunsTableMark, force);
    require_replaceable(beside("_curves.csv"), kCurvesTableMark, force);
  } else if (format == "json") {
    require_replaceable(beside(".json"), kStudyJsonMark, force, {database});
  }
}

void require_replaceable_page(const fs::path& results, bool force) {
  const fs::path page = default_report_path(results);
  if (page == results) {
    throw DataError(results.string(), 0, "a name that does not end in .html, which its page gets",
                    results.filename().string());
  }
  require_replaceable(page, kPageMark, force, {results});
}

}  // namespace limber::app
