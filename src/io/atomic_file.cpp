// SPDX-License-Identifier: MIT
#include "limber/io/atomic_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <ranges>
#include <system_error>
#include <utility>

#include "limber/core/errors.hpp"

namespace limber {

std::filesystem::path temporary_name_beside(const std::filesystem::path& path) {
  static std::atomic<unsigned> count = 0;
  return path.parent_path() / fmt::format(".{}.{}-{}.partial", path.filename().string(), getpid(), count++);
}

AtomicFile::AtomicFile(std::filesystem::path path)
    : path_(std::move(path)), temporary_(temporary_name_beside(path_)) {
  if (std::error_code error; std::filesystem::is_directory(path_, error)) {
    throw DataError(path_.string(), 0, "a file name to write to", "a folder");
  }
  stream_.open(temporary_, std::ios::binary | std::ios::trunc);
  if (!stream_) {
    throw DataError(path_.string(), 0, "a place where a file can be written", std::strerror(errno));
  }
}

AtomicFile::~AtomicFile() {
  if (!temporary_.empty()) {
    stream_.close();
    std::error_code ignored;
    std::filesystem::remove(temporary_, ignored);
  }
}

void AtomicFile::write(std::string_view content) {
  stream_.write(content.data(), static_cast<std::streamsize>(content.size()));
  if (!stream_) {
    throw DataError(path_.string(), 0, "room to write the file", std::strerror(errno));
  }
}

void AtomicFile::commit() {
  stream_.close();
  if (!stream_) {
    throw DataError(path_.string(), 0, "room to write the file", std::strerror(errno));
  }
  std::error_code error;
  std::filesystem::rename(temporary_, path_, error);
  if (error) {
    throw DataError(path_.string(), 0, "a place where a file can be written", error.message());
  }
  temporary_.clear();
}

FolderUnlessEmpty::FolderUnlessEmpty(const std::filesystem::path& path) : FolderUnlessEmpty() {
  for (auto folder = path; !folder.empty() && !std::filesystem::exists(folder);
       folder = folder.parent_path()) {
    made_.push_back(folder);
  }
  for (const auto& folder : made_ | std::views::reverse) {
    std::filesystem::create_directory(folder);
  }
}

FolderUnlessEmpty::~FolderUnlessEmpty() {
  std::error_code ignored;
  for (const auto& folder : made_) {
    std::filesystem::remove(folder, ignored);
  }
}

StagedFolder::StagedFolder(std::filesystem::path final_name)
    : final_name_(std::move(final_name)), staging_(temporary_name_beside(final_name_)) {
  std::filesystem::create_directory(staging_);
}

StagedFolder::~StagedFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(staging_, ignored);
}

void StagedFolder::replace() {
  const std::filesystem::path old = temporary_name_beside(final_name_);
  const bool replaces = std::filesystem::exists(final_name_);
  if (replaces) {
    std::filesystem::rename(final_name_, old);
  }
  std::filesystem::rename(staging_, final_name_);
  if (replaces) {
    std::filesystem::remove_all(old);
  }
}

void StagedFolder::move_files(const std::vector<std::string>& names, const std::filesystem::path& folder) {
  for (const std::string& name : names) {
    std::filesystem::rename(staging_ / name, folder / name);
  }
}

void write_file_atomically(const std::filesystem::path& path, std::string_view content) {
  AtomicFile file(path);
  file.write(content);
  file.commit();
}

}  // namespace limber
