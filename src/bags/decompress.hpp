// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

#include "byte_source.hpp"

namespace limber::detail {

/// @brief A chunk as it was before compression.
/// @param method  "bz2", "lz4" (frame format) or "zstd"
/// @param size    what it must come to [bytes]; beyond 32 MiB memory grows with what really comes, not with
///                what is claimed
/// @param[out] out  the chunk; the memory that it has is used again
/// @throws Damage for another method, broken content, or another size
void decompress(std::string_view method, Bytes content, std::uint64_t size, std::vector<std::uint8_t>& out);

/// CRC-32 as zlib has it.
[[nodiscard]] std::uint32_t crc32_of(Bytes content, std::uint32_t start = 0);

}  // namespace limber::detail
