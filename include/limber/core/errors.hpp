// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

namespace limber {

/// A file that cannot be used: names file, line (0: the whole file), and what was expected and found.
/// what() reads "FILE:LINE: expected EXPECTED, found FOUND".
class DataError : public std::runtime_error {
 public:
  /// @param line  1 is the first; 0: the whole file
  DataError(std::string file, std::size_t line, const std::string& expected, const std::string& found);

  /// As it was opened.
  [[nodiscard]] const std::string& file() const { return file_; }
  /// 1 is the first; 0: the whole file.
  [[nodiscard]] std::size_t line() const { return line_; }
  /// "expected EXPECTED, found FOUND", for texts that are no file.
  [[nodiscard]] std::string without_place() const;

 private:
  std::string file_;
  std::size_t line_;
};

}  // namespace limber
