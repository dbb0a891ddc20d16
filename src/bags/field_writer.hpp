// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "byte_source.hpp"

namespace limber::detail {

inline Bytes as_bytes(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

inline std::string_view as_text(Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Little-endian fields, one after another: what FieldReader reads.
class FieldWriter {
 public:
  template <typename Integer>
  FieldWriter& integer(Integer value) {
    for (std::size_t k = 0; k < sizeof(Integer); ++k) {
      bytes_.push_back(static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * k)));
    }
    return *this;
  }
  /// Length (32 bits), then the bytes.
  FieldWriter& text(std::string_view text) {
    integer(static_cast<std::uint32_t>(text.size()));
    bytes_.append(text);
    return *this;
  }
  FieldWriter& raw(std::string_view bytes) {
    bytes_.append(bytes);
    return *this;
  }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

}  // namespace limber::detail
