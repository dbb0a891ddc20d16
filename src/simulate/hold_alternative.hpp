// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <variant>

namespace limber::detail {

/// Makes `variant` hold its alternative number `index`, default-constructed unless it does already.
template <typename... Alternatives>
void hold_alternative(std::variant<Alternatives...>& variant, std::size_t index) {
  std::size_t i = 0;
  (void)((i++ == index &&
          (std::holds_alternative<Alternatives>(variant) || (variant = Alternatives{}, true))) ||
         ...);
}

}  // namespace limber::detail
