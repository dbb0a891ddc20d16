// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "limber/core/errors.hpp"

namespace limber::detail {

/// Levels of nesting that a JSON file may have: what limber writes has five, and every level costs stack.
inline constexpr int kDeepestJson = 100;

/// @brief A JSON text.
/// @param file  for messages
/// @throws DataError for what is no JSON, and for nesting deeper than kDeepestJson
template <typename Json = nlohmann::ordered_json>
[[nodiscard]] Json parse_json(const std::string& text, const std::string& file) {
  const auto limit = [&file](int depth, typename Json::parse_event_t, const Json&) {
    if (depth > kDeepestJson) {
      throw DataError(file, 0, "JSON", "more than " + std::to_string(kDeepestJson) + " nested levels");
    }
    return true;
  };
  try {
    return Json::parse(text, limit);
  } catch (const nlohmann::json::exception& error) {
    throw DataError(file, 0, "JSON", error.what());
  }
}

/// @brief The text of a JSON value, on one line or indented. Names of files and in bags need not be UTF-8:
/// what is none becomes U+FFFD.
template <typename Json>
[[nodiscard]] std::string json_text(const Json& json, int indent = -1) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace limber::detail
