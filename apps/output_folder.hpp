// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

#include "limber/core/errors.hpp"
#include "limber/io/atomic_file.hpp"

namespace limber::app {

/// @brief Tries whether a folder for results can be made and written, before the long work starts. Leaves no
/// trace, so that nothing is there if the work fails or is killed.
/// @throws DataError if it cannot
inline void require_writable_folder(const std::filesystem::path& path) {
  const auto refuse = [&path](const std::string& found) {
    throw DataError(path.string(), 0, "a folder that can be made and written", found);
  };
  try {
    const FolderUnlessEmpty folder(path);
    if (!std::filesystem::is_directory(path)) {
      refuse("something that is no folder");
    }
    AtomicFile probe(path / ".limber-probe");  // never committed: it only has to open
    probe.write(" ");
  } catch (const std::filesystem::filesystem_error& error) {
    refuse(error.code().message());
  }
}

}  // namespace limber::app
