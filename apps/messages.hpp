// SPDX-License-Identifier: MIT
#pragma once

#include <cstdio>
#include <string>
#include <string_view>

/// What the program says beside its results: always on stderr, so that stdout can be piped. A message that
/// cannot be written (stderr closed, its disk full) is lost: no reason to stop, least of all while an error
/// is on its way.
namespace limber::app {

inline void print_message(std::string_view kind, std::string_view text) {
  std::string line = "limber: ";
  line.append(kind).append(text).push_back('\n');
  (void)std::fwrite(line.data(), 1, line.size(), stderr);
}

inline void print_note(std::string_view text) { print_message("", text); }
inline void print_warning(std::string_view text) { print_message("warning: ", text); }
inline void print_error(std::string_view text) { print_message("error: ", text); }

}  // namespace limber::app
