// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

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

/// A folder, made with its parents where they are missing. At the end, what was made and is still empty goes
/// away again: nothing is left of work that failed.
/// @throws std::filesystem::filesystem_error if it cannot be made
class FolderUnlessEmpty {
 public:
  explicit FolderUnlessEmpty(const std::filesystem::path& path);
  ~FolderUnlessEmpty();
  FolderUnlessEmpty(const FolderUnlessEmpty&) = delete;
  FolderUnlessEmpty& operator=(const FolderUnlessEmpty&) = delete;

 private:
  FolderUnlessEmpty() = default;  ///< delegated to, so that the destructor also follows a failed constructor

  std::vector<std::filesystem::path> made_;  ///< the innermost first
};

/// @brief A folder that is filled under a temporary name beside its final one.
/// Without a commit, for instance when an exception passes, it goes away with everything in it.
/// @throws std::filesystem::filesystem_error from every member if the place cannot be written
class StagedFolder {
 public:
  explicit StagedFolder(std::filesystem::path final_name);
  ~StagedFolder();
  StagedFolder(const StagedFolder&) = delete;
  StagedFolder& operator=(const StagedFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return staging_; }  ///< where to write

  /// Commits the folder: it takes the place of an older one of the final name.
  void replace();
  /// Commits the files instead: moves them, in this order, to `folder`, where they replace older ones.
  void move_files(const std::vector<std::string>& names, const std::filesystem::path& folder);

 private:
  std::filesystem::path final_name_, staging_;
};

/// A name beside `path`, hidden and not used yet by this process: where something is prepared before it is
/// renamed.
[[nodiscard]] std::filesystem::path temporary_name_beside(const std::filesystem::path& path);

}  // namespace limber
