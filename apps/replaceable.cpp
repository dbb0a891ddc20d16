// SPDX-License-Identifier: MIT
#include "replaceable.hpp"

#include <algorithm>
#include <fstream>
#include <string>
#include <system_error>

#include "limber/core/errors.hpp"
#include "limber/datasets/recording_place.hpp"
#include "limber/run_files/run_output.hpp"
#include "limber/run_files/run_results.hpp"
#include "report_files.hpp"
#include "uninterrupted.hpp"

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

[[noreturn]] void refuse(const fs::path& file, const char* found) {
  throw DataError(file.string(), 0, "no file of this name", found);
}

constexpr const char* kEarlier = "an earlier result; --force replaces it";
constexpr const char* kForeign = "one that limber did not write; --force replaces it, too";
constexpr const char* kAnyone = "one; --force replaces it";

/// A file of this name, if it exists, lies within the folder, seen through links.
bool lies_within(const fs::path& file, const fs::path& folder) {
  std::error_code error;
  const fs::path inner = fs::weakly_canonical(file, error), outer = fs::weakly_canonical(folder, error);
  return std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first == outer.end();
}

/// A folder beside the recording that `place` is in.
std::string example_of(const fs::path& place) {
  fs::path recording;
  for (const fs::path& part : place) {
    if (part == "mav0") break;
    recording /= part;
  }
  return recording.string() + "-results";
}

}  // namespace

void require_replaceable(const fs::path& file, std::string_view mark, bool force,
                         const std::vector<fs::path>& inputs) {
  require_regular(file);
  if (!fs::exists(file)) {
    return;
  }
  const bool empty = fs::file_size(file) == 0;
  const bool own = empty || (mark != kNoMark && bears(file, mark));
  for (const fs::path& input : inputs) {
    std::error_code ignored;
    if (fs::equivalent(file, input, ignored) ||
        (!own && fs::is_directory(input) && lies_within(file, input))) {
      throw DataError(file.string(), 0, "a name for the result that is not also an input",
                      "what this command reads");
    }
  }
  if (!empty && !force) {
    refuse(file, mark == kNoMark ? kAnyone : own ? kEarlier : kForeign);
  }
}

void require_remakable(const fs::path& made, std::string_view mark, const fs::path& results, bool force) {
  const bool again = fs::exists(results) && fs::is_regular_file(made) && bears(made, mark);
  require_replaceable(made, mark, force || again, {results});
}

void require_no_recording(const fs::path& folder) {
  const bool in_mav0 = lies_in_mav0(folder);
  if (in_mav0 || holds_recording(folder)) {
    std::error_code ignored;
    const fs::path place = fs::weakly_canonical(fs::absolute(folder), ignored);
    throw DataError(folder.string(), 0, "a folder for the results alone, such as " + example_of(place),
                    in_mav0 ? "one within a recording" : "that of a recording");
  }
}

void require_no_run(const fs::path& folder) {
  if (is_run_folder(folder)) {
    throw DataError(folder.string(), 0, "a folder for the recording alone", "one with the results of a run");
  }
}

void require_replaceable_run(const fs::path& folder, bool force) {
  require_no_recording(folder);
  std::string there;
  for (const std::string& name : run_file_names()) {
    require_regular(folder / name);
    if (fs::exists(folder / name) && there.empty()) {
      there = name;
    }
  }
  if (!there.empty() && !force) {
    if (fs::exists(folder / "summary.json") && bears(folder / "summary.json", kRunMark)) {
      throw DataError(folder.string(), 0, "a folder without results",
                      "those of an earlier run; --force replaces them");
    }
    refuse(folder / there, kForeign);
  }
  require_replaceable(folder / "report.html", kPageMark, force);
}

void write_run(const fs::path& folder, bool force, const RunOptions& options, const RunRecord& record,
               const RunSummary& summary) {
  const Uninterrupted until_written;
  require_replaceable_run(folder, force);
  write_run_output(folder, options, record, summary);
}

void require_replaceable_export(const fs::path& database, std::string_view format, bool force) {
  const auto beside = [&](const char* ending) {
    return database.parent_path() / (database.stem().string() + ending);
  };
  if (format == "csv") {
    require_remakable(beside("_runs.csv"), kRunsTableMark, database, force);
    require_remakable(beside("_curves.csv"), kCurvesTableMark, database, force);
  } else if (format == "json") {
    require_remakable(beside(".json"), kStudyJsonMark, database, force);
  }
}

void require_replaceable_page(const fs::path& results, bool force) {
  const fs::path page = default_report_path(results);
  if (page == results) {
    throw DataError(results.string(), 0, "a name that does not end in .html, which its page gets",
                    results.filename().string());
  }
  require_remakable(page, kPageMark, results, force);
}

}  // namespace limber::app
