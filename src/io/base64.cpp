// SPDX-License-Identifier: MIT
#include "base64.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <string_view>
#include <vector>

namespace limber::detail {
namespace {

constexpr std::string_view kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

std::vector<std::uint8_t> little_endian(std::span<const float> values) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(4 * values.size());
  for (const float value : values) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    for (int shift = 0; shift < 32; shift += 8) {
      bytes.push_back(static_cast<std::uint8_t>(bits >> shift & 0xffu));
    }
  }
  return bytes;
}

}  // namespace

std::string to_base64(std::span<const std::uint8_t> bytes) {
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t k = 0; k < bytes.size(); k += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - k);  // bytes that are left
    std::uint32_t group = 0;
    for (std::size_t n = 0; n < 3; ++n) {
      group = group << 8 | (n < count ? bytes[k + n] : 0u);
    }
    for (std::size_t n = 0; n < 4; ++n) {
      out += n <= count ? kLetters[group >> (18 - 6 * n) & 63u] : '=';
    }
  }
  return out;
}

std::string to_base64(std::span<const float> values) {
  return to_base64(std::span<const std::uint8_t>(little_endian(values)));
}

}  // namespace limber::detail
