// SPDX-License-Identifier: MIT
#include "loss.hpp"

#include <fmt/format.h>

namespace limber::detail {

std::string when_lost(std::optional<std::int64_t> before, std::optional<std::int64_t> after) {
  if (before && after) {
    return fmt::format(", between the messages of {} ns and {} ns", *before, *after);
  }
  return before  ? fmt::format(", behind the message of {} ns", *before)
         : after ? fmt::format(", before the message of {} ns", *after)
                 : "";
}

}  // namespace limber::detail
