// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

namespace limber::app {

using TextRow = std::vector<std::string>;

/// Width of a text in characters (UTF-8).
[[nodiscard]] inline std::size_t width_of(std::string_view text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U;  // not inside a character
  }));
}

/// Columns as wide as what is in them; a row of up to three cells may end on a long one.
[[nodiscard]] inline std::string text_table(const std::vector<TextRow>& rows) {
  std::vector<std::size_t> widths;
  for (const TextRow& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t k = 0; k < row.size(); ++k) {
      const bool last = k + 1 == row.size();
      widths[k] = std::max(widths[k], last && row.size() < 4 ? 0 : width_of(row[k]));
    }
  }
  std::string out;
  for (const TextRow& row : rows) {
    std::string line;
    for (std::size_t k = 0; k < row.size(); ++k) {
      const std::size_t width = width_of(row[k]);
      line += row[k];
      line.append(widths[k] > width ? widths[k] - width + 2 : 2, ' ');
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + "\n";
  }
  return out;
}

}  // namespace limber::app
