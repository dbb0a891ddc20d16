// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "limber/io/atomic_file.hpp"
#include "message_sink.hpp"

namespace limber::detail {

/// @brief A ROS 1 bag (format 2.0) in the making: chunks, with index.
/// @throws DataError from every member if the file cannot be written
class Ros1Writer final : public MessageSink {
 public:
  /// @param compression  none, bz2 or lz4
  Ros1Writer(const std::filesystem::path& path, std::string compression);

  [[nodiscard]] Serialization serialization() const override { return Serialization::kRos1; }
  [[nodiscard]] std::uint16_t channel(const std::string& topic, const MessageType& type,
                                      bool is_latched = false) override;
  void message(std::uint16_t channel, std::int64_t t_ns, Bytes content) override;
  void close() override;

 private:
  struct Chunk {
    std::uint64_t at = 0;                           ///< byte of the record
    std::int64_t first_ns = 0, last_ns = 0;         ///< of its messages
    std::map<std::uint16_t, std::uint32_t> counts;  ///< messages of each connection
  };
  using Entry = std::pair<std::uint64_t, std::uint32_t>;  ///< time as it is written, byte in the chunk

  void put(const std::string& bytes);
  void end_chunk();
  void write_index();

  AtomicFile file_;
  std::string compression_;
  std::uint64_t at_ = 0;                                 ///< bytes written
  std::string content_;                                  ///< of the chunk, not compressed yet
  Chunk chunk_;                                          ///< the one that is filled
  std::map<std::uint16_t, std::vector<Entry>> entries_;  ///< of the chunk
  std::vector<Chunk> chunks_;
  std::vector<std::string> connections_;  ///< records
  std::map<std::string, std::uint16_t> channels_;
};

}  // namespace limber::detail
