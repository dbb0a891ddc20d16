// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

namespace limber::detail {

/// The text of scenarios/NAME.yaml, which the build puts into the program.
/// @throws std::invalid_argument if there is none of that name
[[nodiscard]] std::string_view paper_scenario_text(std::string_view name);

}  // namespace limber::detail
