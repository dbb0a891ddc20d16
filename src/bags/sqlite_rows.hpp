// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "io/sqlite.hpp"

/// The rows of a table whose pages may be damaged.
namespace limber::detail {

/// Rows that the tree of the table does not lead to.
struct RowGap {
  std::optional<std::int64_t> before, after;  ///< rows on either side; nothing: there is none
  std::string why;                            ///< as SQLite says it
};

/// @brief Hands out the rows of a table, numbered from 0 or more, in their order; behind a page that cannot
/// be read it goes on with the first row that can.
/// @param columns  after rowid, of each row
/// @param visit    gets the rowid, and the statement for the columns behind it; what it throws passes through
/// @param missing  is told of rows that cannot be reached, when the rows before have been visited
void visit_rows(const SqliteFile& file, const std::string& table, const std::string& columns,
                const std::function<void(std::int64_t, SqliteStatement&)>& visit,
                const std::function<void(const RowGap&)>& missing);

}  // namespace limber::detail
