// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace limber::detail {

/// Bytes in base64 (RFC 4648, padded).
[[nodiscard]] std::string to_base64(std::span<const std::uint8_t> bytes);

/// Numbers as 32-bit floats, little-endian, in base64: half the size of decimal text with as many digits as a
/// screen can show. NaN stays NaN.
[[nodiscard]] std::string to_base64(std::span<const float> values);

}  // namespace limber::detail
