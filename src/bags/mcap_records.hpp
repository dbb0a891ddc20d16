// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string_view>

/// What reader and writer of MCAP files share: https://mcap.dev/spec
namespace limber::detail::mcap {

using namespace std::string_view_literals;

inline constexpr std::string_view kMagic = "\x89MCAP0\r\n"sv;

enum Op : std::uint8_t {
  kHeader = 1,
  kFooter = 2,
  kSchema = 3,
  kChannel = 4,
  kMessage = 5,
  kChunk = 6,
  kMessageIndex = 7,
  kChunkIndex = 8,
  kAttachment = 9,
  kAttachmentIndex = 10,
  kStatistics = 11,
  kDataEnd = 15,
  kFirstPrivate = 128  ///< what a program may have for itself; between them: nothing yet
};

}  // namespace limber::detail::mcap
