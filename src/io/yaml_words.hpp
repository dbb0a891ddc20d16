// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <cstddef>
#include <string>

#include "io/numbers.hpp"

/// What error messages say of YAML.
namespace limber::detail {

/// The line in the file, counted from 1; 0 if there is none.
inline std::size_t line_of(const YAML::Mark& mark) {
  return mark.is_null() ? 0 : static_cast<std::size_t>(mark.line) + 1;
}

/// What a node is: its text, "a list of 3", "a mapping" or "nothing".
inline std::string in_words(const YAML::Node& node) {
  switch (node.Type()) {
    case YAML::NodeType::Scalar:
      return excerpt(node.Scalar());
    case YAML::NodeType::Sequence:
      return fmt::format("a list of {}", node.size());
    case YAML::NodeType::Map:
      return "a mapping";
    default:
      return "nothing";
  }
}

}  // namespace limber::detail
