// SPDX-License-Identifier: MIT
#include "message_sink.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "mcap_writer.hpp"
#include "ros1_writer.hpp"

namespace limber {

std::span<const std::string_view> compressions_of(BagFormat format) {
  static constexpr std::array<std::string_view, 3> kMcap = {"zstd", "lz4", "none"},
                                                   kRos1 = {"lz4", "bz2", "none"};
  return format == BagFormat::kMcap ? kMcap : kRos1;
}

std::unique_ptr<detail::MessageSink> detail::open_sink(const BagOutput& output) {
  const auto known = compressions_of(output.format);
  const std::string compression(output.compression.empty() ? known.front() : output.compression);
  if (std::find(known.begin(), known.end(), compression) == known.end()) {
    throw std::invalid_argument("compression '" + compression + "', which " +
                                (output.format == BagFormat::kMcap ? "MCAP files" : "ROS 1 bags") +
                                " do not have");
  }
  if (output.format == BagFormat::kMcap) {
    return std::make_unique<McapWriter>(output.path, compression);
  }
  return std::make_unique<Ros1Writer>(output.path, compression);
}

}  // namespace limber
