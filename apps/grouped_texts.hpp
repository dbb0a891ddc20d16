// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace limber::app {

/// Each text once, in the order of the first ones who say it, with all who say it.
[[nodiscard]] inline std::vector<std::pair<std::string, std::vector<std::string>>> by_text(
    const std::vector<std::string>& who, const std::map<std::string, std::vector<std::string>>& texts_of) {
  std::vector<std::pair<std::string, std::vector<std::string>>> out;
  for (const std::string& one : who) {
    const auto texts = texts_of.find(one);
    for (const std::string& text : texts != texts_of.end() ? texts->second : std::vector<std::string>{}) {
      const auto known =
          std::find_if(out.begin(), out.end(), [&](const auto& item) { return item.first == text; });
      (known != out.end() ? *known : out.emplace_back(text, std::vector<std::string>{}))
          .second.push_back(one);
    }
  }
  return out;
}

}  // namespace limber::app
