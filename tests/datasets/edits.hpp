// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string>

#include "datasets/files.hpp"

/// Ways to spoil a file.
namespace limber::testing {

/// What happens to the text of a file.
using Edit = std::function<std::string(const std::string&)>;

inline Edit replace(const std::string& from, const std::string& to) {
  return [=](const std::string& text) { return replaced(text, from, to); };
}

/// Replaces what stands between `begin` and the next `end`.
inline Edit replace_between(const std::string& begin, const std::string& end, const std::string& to) {
  return [=](const std::string& text) {
    const std::size_t from = text.find(begin) + begin.size(), until = text.find(end, from);
    if (from < begin.size() || until == std::string::npos) {
      throw std::invalid_argument("replace_between: no '" + begin + "' ... '" + end + "' in the text");
    }
    return text.substr(0, from) + to + text.substr(until);
  };
}

inline Edit append(const std::string& tail) {
  return [=](const std::string& text) { return text + tail; };
}

inline Edit cut_end(std::size_t bytes) {
  return [=](const std::string& text) { return text.substr(0, text.size() - bytes); };
}

inline Edit header_only() {
  return [](const std::string& text) { return text.substr(0, text.find('\n') + 1); };
}

/// Applies the edit to the file.
inline void edit_file(const fs::path& path, const Edit& edit) { write_text(path, edit(read_text(path))); }

}  // namespace limber::testing
