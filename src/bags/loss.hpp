// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

/// What is said of messages that are lost.
namespace limber::detail {

/// So many losses are told one by one.
inline constexpr std::size_t kMostDamages = 5;

/// ", between the messages of 1 ns and 2 ns": bag times of those before and behind; nothing: there is none.
[[nodiscard]] std::string when_lost(std::optional<std::int64_t> before, std::optional<std::int64_t> after);

}  // namespace limber::detail
