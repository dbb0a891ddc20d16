// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "byte_source.hpp"
#include "limber/bags/write_bag.hpp"
#include "message_types.hpp"

namespace limber::detail {

/// A file of messages in the making.
class MessageSink {
 public:
  virtual ~MessageSink() = default;
  /// How its messages are serialised.
  [[nodiscard]] virtual Serialization serialization() const = 0;
  /// @param is_latched  what comes late to the topic still gets its last message (ROS 1 alone can say so)
  /// @return the channel of a topic, for message()
  [[nodiscard]] virtual std::uint16_t channel(const std::string& topic, const MessageType& type,
                                              bool is_latched = false) = 0;
  virtual void message(std::uint16_t channel, std::int64_t t_ns, Bytes content) = 0;
  virtual void close() = 0;  ///< call once, last: the file gets its name
};

/// @throws DataError if the file cannot be written, std::invalid_argument for an unknown compression
[[nodiscard]] std::unique_ptr<MessageSink> open_sink(const BagOutput& output);

}  // namespace limber::detail
