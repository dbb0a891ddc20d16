// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/sqlite.hpp"
#include "limber/study/run_figures.hpp"

/// The tables of a study. docs/study-database.md describes them.
namespace limber::detail {

/// Goes up whenever tables or the meaning of a column change.
inline constexpr int kSchemaVersion = 3;

/// What SqliteFile is told that it opens.
inline constexpr const char* kStudyFile = "a study, an SQLite database";

/// Whether nothing has been written into the file yet.
[[nodiscard]] bool is_empty(const SqliteFile& file);

/// @throws DataError unless the file is a study of kSchemaVersion, with rows that fit together
/// (check_content)
void check_schema(const SqliteFile& file);

/// Makes the tables; within a transaction of the caller.
void create_schema(SqliteFile& file);

/// "position_rmse_m, ...": all figures. With placeholders "?, ...".
[[nodiscard]] std::string figure_columns();
[[nodiscard]] std::string figure_placeholders();

/// The columns of a run from `run` on, in the order in which put_run and get_run have them.
[[nodiscard]] std::string run_columns();
void put_run(SqliteStatement& statement, const StudyRun& run);
[[nodiscard]] StudyRun get_run(SqliteStatement& statement);

}  // namespace limber::detail
