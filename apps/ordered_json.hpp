// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>

namespace limber::app {

/// Keeps the order in which keys are added.
using Json = nlohmann::ordered_json;

}  // namespace limber::app
