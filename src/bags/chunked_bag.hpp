// SPDX-License-Identifier: MIT
#pragma once

#include <deque>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "byte_source.hpp"
#include "limber/bags/bag_file.hpp"

namespace limber::detail {

/// A compressed chunk, as the record that holds it describes it.
struct ChunkHead {
  std::uint64_t at = 0;  ///< byte of the record in the file
  std::string compression;
  std::uint64_t size = 0;          ///< [bytes] once decompressed
  std::uint64_t content_at = 0;    ///< byte of the compressed content in the file
  std::uint64_t content_size = 0;  ///< [bytes]
  std::uint32_t crc = 0;           ///< of the decompressed content; 0: unknown
  [[nodiscard]] bool is_compressed() const { return !compression.empty() && compression != "none"; }
};

/// What ROS 1 bags and MCAP files share: records one after another, some of them chunks of more records.
class ChunkedBag : public BagFile {
 public:
  explicit ChunkedBag(const std::filesystem::path& path) : file_(path) {}

  [[nodiscard]] std::vector<std::uint8_t> read(const BagPlace& place) final;
  [[nodiscard]] const std::vector<BagTopic>& topics() const final { return topics_; }
  [[nodiscard]] const std::vector<std::string>& damages() const final { return damages_; }
  void walk(const Wanted& wanted, const Visitor& visitor) final;

 protected:
  /// Where records are read from: the file, or a chunk.
  struct Place {
    ByteSource& bytes;
    std::uint64_t begin, end;
    const ChunkHead* chunk;  ///< the compressed one that holds them; null: none
  };

  /// Makes the channels known that an index at the end of the file lists, if there is one: the chunk that
  /// introduces a channel may be the damaged one. @throws Damage
  virtual void read_index() = 0;
  /// Visits the records of the whole file, through visit(), walk_chunk() and damaged(). @throws Damage
  virtual void walk_file() = 0;
  /// The records of a chunk. @throws Damage
  virtual void walk_records(const Place& place) = 0;
  /// Head of the chunk that begins at byte `at`. @throws Damage
  [[nodiscard]] virtual ChunkHead chunk_at(std::uint64_t at) = 0;

  /// Visits what is in a chunk; damage in it is noted and ends there.
  void walk_chunk(const ChunkHead& head);
  /// Visits a message of the channel whose bytes are [at, at + size) of `place`.
  void visit(const Place& place, std::uint64_t channel, std::int64_t t_ns, std::uint64_t at,
             std::uint64_t size);
  /// Makes a channel known; the same again is nothing new. Channels of one topic are one topic.
  void add_channel(std::uint64_t channel, const BagTopic& topic);
  [[nodiscard]] bool knows(std::uint64_t channel) const { return channels_.contains(channel); }
  void damaged(std::uint64_t at, std::string_view what);

  FileBytes file_;

 private:
  /// @param[out] content  its memory is used again. @throws Damage
  void unpack(const ChunkHead& head, std::vector<std::uint8_t>& content);
  /// The chunk whose record begins at byte `at`, decompressed, until the next but two is asked for.
  [[nodiscard]] const std::vector<std::uint8_t>& chunk_content(std::uint64_t at);

  std::vector<BagTopic> topics_;
  std::vector<std::size_t> wanted_bytes_;          ///< of each topic
  std::map<std::uint64_t, std::size_t> channels_;  ///< to indices of topics_
  std::vector<std::string> damages_;
  std::size_t more_damages_ = 0;
  std::size_t unknown_ = 0;  ///< messages of channels that nothing introduces
  const Wanted* wanted_ = nullptr;
  const Visitor* visitor_ = nullptr;
  std::deque<std::pair<std::uint64_t, std::vector<std::uint8_t>>> recent_;  ///< decompressed chunks
  std::vector<std::uint8_t> packed_,
      walked_;  ///< a chunk as it is stored, and the one that is walked through
};

}  // namespace limber::detail
