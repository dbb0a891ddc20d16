// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <system_error>

#include "limber/core/errors.hpp"
#include "limber/datasets/atomic_file.hpp"

namespace limber::app {

/// A folder for results: made and tried before the long work starts, taken away again if the work fails and
/// nothing was written.
class OutputFolder {
 public:
  /// @throws DataError if it cannot be made or written
  explicit OutputFolder(std::filesystem::path path)
      : path_(std::move(path)), existed_(std::filesystem::exists(path_)) {
    std::error_code error;
    std::filesystem::create_directories(path_, error);
    if (error || !std::filesystem::is_directory(path_)) {
      throw DataError(path_.string(), 0, "a folder that can be made and written",
                      error ? error.message() : "something that is no folder");
    }
    AtomicFile probe(path_ / ".limber-probe");  // never committed: it only has to open
    probe.write(" ");
  }
  ~OutputFolder() {
    std::error_code ignored;
    if (!existed_) {
      std::filesystem::remove(path_, ignored);  // only if it is empty
    }
  }
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  bool existed_;
};

}  // namespace limber::app
