// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <string_view>

/// What the program says beside its results: always on stderr, so that stdout can be piped.
namespace limber::app {

inline void print_note(std::string_view text) { fmt::print(stderr, "limber: {}\n", text); }
inline void print_warning(std::string_view text) { fmt::print(stderr, "limber: warning: {}\n", text); }
inline void print_error(std::string_view text) { fmt::print(stderr, "limber: error: {}\n", text); }

}  // namespace limber::app
