// SPDX-License-Identifier: MIT
#include "limber/io/atomic_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <random>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

#include "limber/core/errors.hpp"

namespace limber {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kEnding = ".partial";
constexpr std::size_t kBuffer = std::size_t{1} << 16;  // [bytes]
constexpr int kAttempts = 100;

[[noreturn]] void fail_with_errno(const char* what, const fs::path& path) {
  throw fs::filesystem_error(what, path, std::error_code(errno, std::generic_category()));
}

fs::path folder_of(const fs::path& path) { return path.has_parent_path() ? path.parent_path() : "."; }

std::string beginning_of(const fs::path& final_name) {
  return fmt::format(".{}.", final_name.filename().string());
}

/// Removes what killed processes left for the same final name: nobody holds its lock.
void remove_abandoned(const fs::path& final_name) {
  const std::string beginning = beginning_of(final_name);
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder_of(final_name), error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(beginning) || !name.ends_with(kEnding)) {
      continue;
    }
    const int descriptor = open(entry.path().c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (descriptor >= 0 && flock(descriptor, LOCK_EX | LOCK_NB) == 0) {
      std::error_code ignored;
      fs::remove_all(entry.path(), ignored);
    }
    if (descriptor >= 0) {
      close(descriptor);
    }
  }
}

/// @return a descriptor of what was made; -1, and errno, if it cannot be
int make_new(const fs::path& path, Temporary::Kind kind) {
  if (kind == Temporary::Kind::kFile) {
    return open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
  }
  return mkdir(path.c_str(), 0777) == 0 ? open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC)
                                        : -1;
}

}  // namespace

Temporary::Temporary(const fs::path& final_name, Kind kind) {
  remove_abandoned(final_name);
  std::random_device random;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    path_ = final_name.parent_path() /
            fmt::format("{}{:08x}{:08x}{}", beginning_of(final_name), random(), random(), kEnding);
    descriptor_ = make_new(path_, kind);
    if (descriptor_ >= 0) {
      flock(descriptor_, LOCK_EX);  // where locks do not exist nothing counts as abandoned either
      if (fs::exists(path_)) {
        return;
      }
      close(descriptor_);  // somebody took it for abandoned before it was locked
    } else if (errno != EEXIST) {
      break;
    }
  }
  fail_with_errno("cannot be made", path_);
}

Temporary::~Temporary() {
  if (!path_.empty()) {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  if (descriptor_ >= 0) {
    close(descriptor_);
  }
}

void Temporary::release() { path_.clear(); }

AtomicFile::AtomicFile(std::filesystem::path path) : path_(std::move(path)) {
  std::error_code error;
  const fs::file_status status = fs::status(path_, error);
  if (fs::is_directory(status)) {
    throw DataError(path_.string(), 0, "a file name to write to", "a folder");
  }
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw DataError(path_.string(), 0, "a regular file to replace, or none", "a device, a pipe or the like");
  }
  try {
    temporary_.emplace(path_, Temporary::Kind::kFile);
  } catch (const fs::filesystem_error& e) {
    throw DataError(path_.string(), 0, "a place where a file can be written", e.code().message());
  }
}

void AtomicFile::write(std::string_view content) {
  waiting_ += content;
  if (waiting_.size() >= kBuffer) {
    flush();
  }
}

void AtomicFile::overwrite(std::uint64_t at, std::string_view content) {
  flush();
  if (at > written_ || content.size() > written_ - at) {
    throw std::invalid_argument("AtomicFile::overwrite: bytes that are not written yet");
  }
  put(at, content);
}

void AtomicFile::put(std::uint64_t at, std::string_view content) {
  while (!content.empty()) {
    const ssize_t written =
        pwrite(temporary_->descriptor(), content.data(), content.size(), static_cast<off_t>(at));
    if (written < 0 && errno == EINTR) {
      continue;
    }
    if (written <= 0) {
      throw DataError(path_.string(), 0, "room to write the file", std::strerror(errno));
    }
    content.remove_prefix(static_cast<std::size_t>(written));
    at += static_cast<std::uint64_t>(written);
  }
}

void AtomicFile::flush() {
  put(written_, waiting_);
  written_ += waiting_.size();
  waiting_.clear();
}

void AtomicFile::commit() {
  flush();
  std::error_code error;
  fs::rename(temporary_->path(), path_, error);
  if (error) {
    throw DataError(path_.string(), 0, "a place where a file can be written", error.message());
  }
  temporary_->release();
}

FolderUnlessEmpty::FolderUnlessEmpty(const std::filesystem::path& path) : FolderUnlessEmpty() {
  for (auto folder = path; !folder.empty() && !std::filesystem::exists(folder);
       folder = folder.parent_path()) {
    made_.push_back(folder);
  }
  for (auto folder = made_.rbegin(); folder != made_.rend(); ++folder) {
    std::filesystem::create_directory(*folder);
  }
}

FolderUnlessEmpty::~FolderUnlessEmpty() {
  std::error_code ignored;
  for (const auto& folder : made_) {
    std::filesystem::remove(folder, ignored);
  }
}

StagedFolder::StagedFolder(std::filesystem::path final_name)
    : final_name_(std::move(final_name)), staging_(final_name_, Temporary::Kind::kFolder) {}

void StagedFolder::replace() {
  if (!fs::exists(final_name_)) {
    fs::rename(staging_.path(), final_name_);
  } else {
    const Temporary aside(final_name_, Temporary::Kind::kFolder);  // goes away with what stood there
    const fs::path old = aside.path() / "old";
    fs::rename(final_name_, old);
    try {
      fs::rename(staging_.path(), final_name_);
    } catch (...) {
      fs::rename(old, final_name_);
      throw;
    }
  }
  staging_.release();
}

void StagedFolder::move_files(const std::vector<std::string>& names, const std::filesystem::path& folder) {
  for (const std::string& name : names) {
    std::filesystem::rename(staging_.path() / name, folder / name);
  }
}

void write_file_atomically(const std::filesystem::path& path, std::string_view content) {
  AtomicFile file(path);
  file.write(content);
  file.commit();
}

void write_staged_file(const fs::path& path, std::string_view content) {
  fs::create_directories(path.parent_path());
  std::ofstream stream(path, std::ios::binary);
  stream.write(content.data(), static_cast<std::streamsize>(content.size()));
  stream.close();
  if (!stream) {
    throw DataError(path.string(), 0, "room to write the file", "a write that failed");
  }
}

}  // namespace limber
