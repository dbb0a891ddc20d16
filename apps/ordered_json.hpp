// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace limber::app {

/// Keeps the order in which keys are added.
using Json = nlohmann::ordered_json;

/// Its text. Names of files and in bags need not be UTF-8: what is none becomes U+FFFD.
inline std::string json_text(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace limber::app
