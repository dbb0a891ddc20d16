// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>

namespace limber::detail {

/// Numbers as 32-bit floats, little-endian, in base64 (RFC 4648, padded): half the size of decimal text with
/// as many digits as a screen can show. NaN stays NaN.
[[nodiscard]] std::string to_base64(std::span<const float> values);

}  // namespace limber::detail
