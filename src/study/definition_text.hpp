// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "limber/run/run_options.hpp"

namespace limber::detail {

/// What definition_of says, of a scenario as text.
[[nodiscard]] std::string definition_text(const std::string& scenario, StartMode start,
                                          const std::vector<std::string>& methods);

}  // namespace limber::detail
