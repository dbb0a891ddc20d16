// SPDX-License-Identifier: MIT
#pragma once

#include "io/sqlite.hpp"

namespace limber::detail {

/// @brief What the rows of a study say: types and ranges of all columns, and that whatever a row refers to is
/// there.
/// @throws DataError, which names table and row
void check_content(const SqliteFile& file);

}  // namespace limber::detail
