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

/// @brief An MCAP file in the making: ROS 2 messages in chunks, with index.
/// @throws DataError from every member if the file cannot be written
class McapWriter final : public MessageSink {
 public:
  /// @param compression  none, lz4 or zstd
  McapWriter(const std::filesystem::path& path, std::string compression);

  [[nodiscard]] Serialization serialization() const override { return Serialization::kCdr; }
  [[nodiscard]] std::uint16_t channel(const std::string& topic, const MessageType& type,
                                      bool is_latched = false) override;
  void message(std::uint16_t channel, std::int64_t t_ns, Bytes content) override;
  void close() override;

 private:
  struct Chunk {
    std::uint64_t first_ns = 0, last_ns = 0, at = 0, size = 0, index_size = 0, packed = 0, unpacked = 0;
    std::map<std::uint16_t, std::uint64_t> indices;  ///< channel to byte of its message index
  };
  using Entry = std::pair<std::uint64_t, std::uint64_t>;  ///< time, byte in the chunk

  void put(const std::string& bytes);
  void end_chunk();
  void write_summary();

  AtomicFile file_;
  std::string compression_;
  std::uint64_t at_ = 0;                                 ///< bytes written
  std::string chunk_;                                    ///< records, not compressed yet
  std::uint64_t first_ns_ = 0, last_ns_ = 0;             ///< of the chunk
  std::map<std::uint16_t, std::vector<Entry>> entries_;  ///< of the chunk
  std::vector<Chunk> chunks_;
  std::vector<std::string> definitions_;  ///< records of schemas and channels
  std::map<std::string, std::uint16_t> schemas_, channels_;
  std::map<std::uint16_t, std::uint64_t> counts_;  ///< messages of each channel
};

}  // namespace limber::detail
