// SPDX-License-Identifier: MIT
#include "limber/core/errors.hpp"

#include <utility>

namespace limber {
namespace {

std::string message(const std::string& file, std::size_t line, const std::string& expected,
                    const std::string& found) {
  const std::string place = line > 0 ? file + ":" + std::to_string(line) : file;
  return place + ": expected " + expected + ", found " + found;
}

}  // namespace

DataError::DataError(std::string file, std::size_t line, const std::string& expected,
                     const std::string& found)
    : std::runtime_error(message(file, line, expected, found)), file_(std::move(file)), line_(line) {}

}  // namespace limber
