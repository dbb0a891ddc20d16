// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "limber/study/study_database.hpp"

namespace limber {

/// @brief A study as CSV, beside `database`: NAME_runs.csv (a row per run and method, with all figures) and
/// NAME_curves.csv (a row per case, method and frame, with the mean of every quantity over the runs). What is
/// not known is an empty cell.
/// @return the files. @throws DataError if they cannot be written
std::vector<std::filesystem::path> export_csv(const StudyDatabase& study,
                                              const std::filesystem::path& database);

/// The same as NAME.json, with scenarios and how many runs enter each mean; what is not known is null.
std::vector<std::filesystem::path> export_json(const StudyDatabase& study,
                                               const std::filesystem::path& database);

}  // namespace limber
