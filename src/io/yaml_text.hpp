// SPDX-License-Identifier: MIT
#pragma once

#include <yaml-cpp/yaml.h>

#include <string>

namespace limber::detail {

/// @brief The one document of a YAML text.
/// @param file  for messages
/// @return the root, which may be null: an empty text
/// @throws DataError (file, line) for what is no YAML, a key that stands twice, and more than one document
[[nodiscard]] YAML::Node parse_yaml(const std::string& text, const std::string& file);

}  // namespace limber::detail
