// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <fstream>
#include <string_view>

namespace limber {

/// @brief A file that appears complete or not at all.
/// What is written goes to a temporary name in the same folder, which commit() renames. Without commit(),
/// for instance when an exception passes, the temporary file is removed and an older file keeps its content.
/// @throws DataError from every member if the place cannot be written; the message names the path.
class AtomicFile {
 public:
  explicit AtomicFile(std::filesystem::path path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(std::string_view content);  ///< appends; bytes as they are
  void commit();                         ///< call once, last

 private:
  std::filesystem::path path_, temporary_;
  std::ofstream stream_;
};

/// Writes `content` to `path` in one go, see AtomicFile. The folder must exist.
void write_file_atomically(const std::filesystem::path& path, std::string_view content);

/// A name beside `path`, hidden and not used yet by this process: where something is prepared before it is
/// renamed.
[[nodiscard]] std::filesystem::path temporary_name_beside(const std::filesystem::path& path);

}  // namespace limber
