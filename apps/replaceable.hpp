// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "limber/diagnose/run_summary.hpp"

/// What limber may replace: nothing, unless --force is given; then any regular file of a result's name, but
/// never what a command reads. The mark of each kind of file tells limber's own, for the message, and for
/// what is made anew from results beside it, by which nothing is lost.
namespace limber::app {

inline constexpr const char* kEarlierRecording = "Replace an older recording that limber wrote";

inline void add_force_option(
    CLI::App& command, bool& force,
    const std::string& description = "Replace earlier results, and other files of their names") {
  command.add_flag("--force", force, description);
}

inline constexpr std::string_view kNoMark;  ///< of kinds that others write just as well
inline constexpr std::string_view kPageMark = "<meta name=\"generator\" content=\"limber\">";
inline constexpr std::string_view kEvaluationMark = "\"matched_by\"";
inline constexpr std::string_view kRunMark = "\"realtime_factor\"";  ///< in summary.json
inline constexpr std::string_view kRunsTableMark = "case,method,run,diverged_frame";
inline constexpr std::string_view kCurvesTableMark = "case,method,t [s],runs";
inline constexpr std::string_view kStudyJsonMark = "\"program_version\"";

/// @param inputs  files and folders that the command reads
/// @throws DataError unless `file` is missing or empty; with `force` it may be any regular file but an input
///         and, without the mark, what lies in one
void require_replaceable(const std::filesystem::path& file, std::string_view mark, bool force,
                         const std::vector<std::filesystem::path>& inputs = {});

/// The same for `made`, which limber makes of the results beside it: its own may be there, if they are, too.
void require_remakable(const std::filesystem::path& made, std::string_view mark,
                       const std::filesystem::path& results, bool force);

/// Results beside the files of a recording would be taken for what belongs to it.
/// @throws DataError if the folder is that of a recording, or lies in a mav0
void require_no_recording(const std::filesystem::path& folder);

/// The other way round. @throws DataError if the folder holds the results of a run
void require_no_run(const std::filesystem::path& folder);

/// The results of a run and its page, and no recording beside them. @throws DataError
void require_replaceable_run(const std::filesystem::path& folder, bool force);

/// @brief write_run_output, without being interrupted: unless another run has put its results there
/// meanwhile.
/// @throws DataError
void write_run(const std::filesystem::path& folder, bool force, const RunOptions& options,
               const RunRecord& record, const RunSummary& summary);

/// What export_csv or export_json write beside a database.
void require_replaceable_export(const std::filesystem::path& database, std::string_view format, bool force);

/// The page of results where make_report_beside puts it. The name must not be that of the results.
void require_replaceable_page(const std::filesystem::path& results, bool force);

}  // namespace limber::app
