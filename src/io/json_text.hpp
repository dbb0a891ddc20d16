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

}  // namespace limber::detail
