// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

namespace limber::detail {

/// @brief What decompress() turns back.
/// @param method  "none", "bz2", "lz4" (frames as ROS 1 reads them: independent blocks, no size) or "zstd"
/// @throws std::runtime_error if the compressor refuses
[[nodiscard]] std::string compress(std::string_view method, const std::string& content);

}  // namespace limber::detail
