// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

/// `limber run --methods`: several methods on one recording, and their comparison.
namespace limber::app {

/// The page of the comparison, in the folder that holds those of the runs.
inline constexpr const char* kComparisonPage = "comparison.html";

/// Names as --method takes them, in lower case.
/// @throws CLI::ValidationError if one comes twice
[[nodiscard]] std::vector<std::string> different_methods(const std::vector<std::string>& names);

/// Runs one method into a folder, and says what there is to note.
/// @throws CLI::RuntimeError after it has written what is partial or lost, else like run_recording
using RunOneMethod = std::function<void(const std::string& method, const std::filesystem::path& folder,
                                        std::vector<std::string>& notes)>;

/// @brief Runs each method into out/METHOD, one after the other, then prints each note once and the table of
/// compare_runs, and makes its page. A method that fails (diverges, lacks what it needs) does not keep the
/// others from running; Ctrl-C does, and what is done is kept.
/// @throws DataError before the work if a result would replace what limber did not write
/// @throws CLI::RuntimeError with the worst exit code of the runs, unless all are done
void run_methods(const std::vector<std::string>& methods, const std::filesystem::path& out, bool force,
                 const RunOneMethod& run);

}  // namespace limber::app
