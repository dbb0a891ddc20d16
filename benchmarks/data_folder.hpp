// SPDX-License-Identifier: MIT
#pragma once

#include <cstdlib>
#include <filesystem>

/// Where the real recordings are: the folder LIMBER_DATA, else beside the repository.
inline std::filesystem::path data_folder() {
  const char* const given = std::getenv("LIMBER_DATA");
  return given != nullptr ? std::filesystem::path(given)
                          : std::filesystem::path(LIMBER_SOURCE_DIR) / ".." / "shared" / "data";
}
