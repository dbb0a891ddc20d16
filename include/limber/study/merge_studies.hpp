// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

namespace limber {

/// @brief One study from its parts, as run with --shard: the same content as if one call had made it.
/// @param parts studies with one seed; cases of the same name are the same
/// @throws DataError if a part cannot be read or `out` not be written, or `out` exists
/// @throws std::runtime_error if the parts do not belong together, or two hold the same run; nothing is left
/// then
void merge_studies(const std::vector<std::filesystem::path>& parts, const std::filesystem::path& out);

}  // namespace limber
