// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string_view>
#include <vector>

/// What limber may replace: its own earlier results. Each kind of file carries a mark; a regular file with
/// the mark is replaced, any other only with --force, and what a command reads never is.
namespace limber::app {

inline void add_force_option(CLI::App& command, bool& force) {
  command.add_flag("--force", force, "Replace files of the results' names that limber did not write, too");
}

inline constexpr std::string_view kNoMark;  ///< of kinds that others write just as well
inline constexpr std::string_view kPageMark = "<meta name=\"generator\" content=\"limber\">";
inline constexpr std::string_view kEvaluationMark = "\"matched_by\"";
inline constexpr std::string_view kRunMark = "\"realtime_factor\"";  ///< in summary.json
inline constexpr std::string_view kRunsTableMark = "case,method,run,diverged_frame";
inline constexpr std::string_view kCurvesTableMark = "case,method,t [s],runs";
inline constexpr std::string_view kStudyJsonMark = "\"program_version\"";

/// @param inputs  files and folders that the command reads
/// @throws DataError unless `file` is missing, or a regular file with the mark; with `force` any regular
/// file, but for an input and what lies in one
void require_replaceable(const std::filesystem::path& file, std::string_view mark, bool force,
                         const std::vector<std::filesystem::path>& inputs = {});

/// The results of a run and its page: `folder` holds none of these names yet, or those of an earlier run.
/// @throws DataError
void require_replaceable_run(const std::filesystem::path& folder, bool force);

/// What export_csv or export_json write beside a database.
void require_replaceable_export(const std::filesystem::path& database, std::string_view format, bool force);

/// The page of results where make_report_beside puts it. The name must not be that of the results.
void require_replaceable_page(const std::filesystem::path& results, bool force);

}  // namespace limber::app
