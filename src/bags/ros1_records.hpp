// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string_view>

/// What reader and writer of ROS 1 bags share: http://wiki.ros.org/Bags/Format/2.0
namespace limber::detail::ros1 {

inline constexpr std::string_view kMagic = "#ROSBAG V2.0\n";

enum Op : std::uint8_t {
  kMessage = 2,
  kBagHeader = 3,
  kIndex = 4,
  kChunk = 5,
  kChunkInfo = 6,
  kConnection = 7
};

}  // namespace limber::detail::ros1
