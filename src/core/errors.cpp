// SPDX-License-Identifier: MIT
#include "limber/core/errors.hpp"

#include <utility>

namespace limber {
namespace {

/// With what stands between it and the message.
std::string place(const std::string& file, std::size_t line) {
  return (line > 0 ? file + ":" + std::to_string(line) : file) + ": ";
}

}  // namespace

DataError::DataError(std::string file, std::size_t line, const std::string& expected,
                     const std::string& found)
    : std::runtime_error(place(file, line) + "expected " + expected + ", found " + found),
      file_(std::move(file)),
      line_(line) {}

std::string DataError::without_place() const { return what() + place(file_, line_).size(); }

}  // namespace limber
