// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cctype>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace limber {

/// ASCII letters in lower case.
[[nodiscard]] inline std::string in_lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// Letters to insert, leave out or replace to turn one word into the other (Levenshtein).
[[nodiscard]] inline std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

/// The known word that somebody may have meant: at most two letters away and less than half of the word;
/// nothing if there is none.
[[nodiscard]] inline std::optional<std::string> nearest_word(const std::string& word,
                                                             std::span<const std::string> known) {
  const auto distance = [&word](const std::string& other) {
    return edit_distance(in_lower_case(word), in_lower_case(other));
  };
  const auto nearest = std::min_element(
      known.begin(), known.end(), [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
  if (nearest == known.end() || distance(*nearest) > 2 || 2 * distance(*nearest) >= word.size()) {
    return std::nullopt;
  }
  return *nearest;
}

/// " (did you mean WORD?)" with the nearest known word, or nothing.
[[nodiscard]] inline std::string did_you_mean(std::string_view word, std::span<const std::string> known) {
  const auto meant = nearest_word(std::string(word), known);
  return meant ? " (did you mean " + *meant + "?)" : "";
}

}  // namespace limber
