// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace limber {

/// A file or a folder under a name that nobody can foresee, beside its final one: `.NAME.RANDOM.partial`. It
/// is made new (an old file or link of that name is never followed) and locked while this process works on
/// it. What killed processes left is recognised by its missing lock, and removed when the next one is made.
class Temporary {
 public:
  /// What is made.
  enum class Kind { kFile, kFolder };
  /// @throws std::filesystem::filesystem_error if it cannot be made
  Temporary(const std::filesystem::path& final_name, Kind kind);
  ~Temporary();  ///< removes it, unless release() was called
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;

  /// Its temporary name.
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] int descriptor() const { return descriptor_; }  ///< kFile: open for writing
  void release();                                               ///< it has got its final name

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

/// @brief A file that appears complete or not at all.
/// What is written goes to a Temporary, which commit() renames. Without commit(), for instance when an
/// exception passes, the temporary file is removed and an older file keeps its content. What the name stands
/// for must be a regular file, a link to one, or nothing: devices and pipes are refused.
/// @throws DataError from every member if the place cannot be written; the message names the path.
class AtomicFile {
 public:
  /// @param path  final name; its folder must exist
  explicit AtomicFile(std::filesystem::path path);
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(std::string_view content);  ///< appends; bytes as they are
  /// Puts other bytes in the place of written ones, from byte `at` on.
  /// @throws std::invalid_argument beyond what is written
  void overwrite(std::uint64_t at, std::string_view content);
  void commit();  ///< call once, last

 private:
  void flush();
  void put(std::uint64_t at, std::string_view content);

  std::filesystem::path path_;
  std::optional<Temporary> temporary_;
  std::string waiting_;        ///< not handed to the system yet
  std::uint64_t written_ = 0;  ///< [bytes] handed to it
};

/// Writes `content` to `path` in one go, see AtomicFile. The folder must exist.
void write_file_atomically(const std::filesystem::path& path, std::string_view content);

/// Writes `content` to a file of a folder that is staged itself, and makes its parents where they are
/// missing.
/// @throws DataError if it cannot be written; the message names the path
void write_staged_file(const std::filesystem::path& path, std::string_view content);

/// A folder, made with its parents where they are missing. At the end, what was made and is still empty goes
/// away again: nothing is left of work that failed.
/// @throws std::filesystem::filesystem_error if it cannot be made
class FolderUnlessEmpty {
 public:
  /// Makes what is missing of it.
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
  /// @param final_name  its parents are made where they are missing
  explicit StagedFolder(std::filesystem::path final_name);
  StagedFolder(const StagedFolder&) = delete;
  StagedFolder& operator=(const StagedFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return staging_.path(); }  ///< where to write

  /// Commits the folder: it takes the place of an older one of the final name.
  void replace();
  /// Commits the files instead: moves them, in this order, to `folder`, where they replace older ones.
  void move_files(const std::vector<std::string>& names, const std::filesystem::path& folder);

 private:
  std::filesystem::path final_name_;
  Temporary staging_;
};

}  // namespace limber
