// SPDX-License-Identifier: MIT
#pragma once

#include <deque>
#include <map>
#include <optional>
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

/// Part of a bag that is left out, and the messages around it.
struct Loss {
  std::uint64_t at = 0, bytes = 0;  ///< in the file
  std::string what;
  std::optional<std::int64_t> before, after;  ///< bag times [ns]; nothing: there is no message
};

/// @brief What ROS 1 bags and MCAP files share: records one after another, some of them chunks of more
/// records. Behind a damaged record the walk goes on with the next one that can be told from other bytes.
class ChunkedBag : public BagFile {
 public:
  explicit ChunkedBag(const std::filesystem::path& path) : file_(path) {}

  [[nodiscard]] std::vector<std::uint8_t> read(const BagPlace& place) final;
  [[nodiscard]] const std::vector<BagTopic>& topics() const final { return topics_; }
  [[nodiscard]] const std::vector<std::string>& damages() const final { return damages_; }
  [[nodiscard]] bool is_whole() const final { return losses_.empty() && unknown_ == 0; }
  void walk(const Wanted& wanted, const Visitor& visitor) final;

 protected:
  /// Where records are read from: the file, or a chunk.
  struct Place {
    ByteSource& bytes;
    std::uint64_t begin, end;
    const ChunkHead* chunk;  ///< the compressed one that holds them; null: none
    bool in_chunk;           ///< compressed or not
  };

  /// Makes known what an index at the end of the file lists, if there is one: channels, whose introduction
  /// may be in a damaged chunk, and add_chunk() for each chunk. @throws Damage
  virtual void read_index() = 0;
  /// The records of the whole file.
  [[nodiscard]] virtual Place whole_file() = 0;
  /// Told that the walk is over.
  virtual void walked() {}
  /// Visits the record at byte `at`. @return where the next one begins. @throws Damage
  [[nodiscard]] virtual std::uint64_t step(const Place& place, std::uint64_t at) = 0;
  /// The first byte in [from, end) where a record begins that cannot be other bytes; `end` if there is none.
  /// @param chunks_only  else also messages
  [[nodiscard]] virtual std::uint64_t find_record(const Place& place, std::uint64_t from, std::uint64_t end,
                                                  bool chunks_only) = 0;
  /// Head of the chunk that begins at byte `at`. @throws Damage
  [[nodiscard]] virtual ChunkHead chunk_at(std::uint64_t at) = 0;

  /// Visits what is in a chunk; damage in it is noted.
  void walk_chunk(const ChunkHead& head);
  /// By the index a chunk begins at byte `at`.
  void add_chunk(std::uint64_t at) { chunks_.push_back(at); }
  /// Where by the index the first chunk behind byte `at` begins whose head is sound; nothing if it lists
  /// none.
  [[nodiscard]] std::optional<std::uint64_t> next_chunk(std::uint64_t at) const;
  [[nodiscard]] bool is_chunk_by_index(std::uint64_t at) const;
  /// Visits a message of the channel whose bytes are [at, at + size) of `place`.
  void visit(const Place& place, std::uint64_t channel, std::int64_t t_ns, std::uint64_t at,
             std::uint64_t size);
  /// Makes a channel known; the same again is nothing new. Channels of one topic are one topic.
  void add_channel(std::uint64_t channel, const BagTopic& topic);
  [[nodiscard]] bool knows(std::uint64_t channel) const { return channels_.contains(channel); }
  void lost(std::uint64_t at, std::uint64_t bytes, std::string what);
  /// Nothing is lost, but this is worth a word.
  void remark(std::string what) { remarks_.push_back(std::move(what)); }
  /// Bag time of the last message visited [ns].
  [[nodiscard]] std::optional<std::int64_t> last_time() const { return last_t_ns_; }

  FileBytes file_;

 private:
  void walk_records(const Place& place);
  void note_damage(const Place& place, std::uint64_t at, std::uint64_t bytes, std::string_view what);
  /// Where the walk goes on that failed at byte `at`, behind the record at byte `before`.
  [[nodiscard]] std::uint64_t resume(const Place& place, std::uint64_t before, std::uint64_t at);
  /// find_record, but for the one at byte `not_at`.
  [[nodiscard]] std::uint64_t find_other(const Place& place, std::uint64_t from, std::uint64_t end,
                                         std::uint64_t not_at, bool chunks_only);
  [[nodiscard]] bool is_sound_chunk(std::uint64_t at);
  /// Whether bytes outside sound chunks may be messages, as in a plain chunk whose head is damaged.
  /// @param chunk  the next one that was found; `end`: none
  [[nodiscard]] bool may_hold_messages(std::uint64_t chunk, std::uint64_t end);
  void tell_damages();
  /// @param[out] content  its memory is used again. @throws Damage
  void unpack(const ChunkHead& head, std::vector<std::uint8_t>& content);
  /// The chunk whose record begins at byte `at`, decompressed, until the next but two is asked for.
  [[nodiscard]] const std::vector<std::uint8_t>& chunk_content(std::uint64_t at);

  std::vector<BagTopic> topics_;
  std::vector<std::size_t> wanted_bytes_;             ///< of each topic
  std::map<std::uint64_t, std::size_t> channels_;     ///< to indices of topics_
  std::vector<std::uint64_t> chunks_, sound_chunks_;  ///< where they begin by the index, in order
  std::optional<std::uint64_t> last_chunk_;           ///< that was walked through
  bool any_compressed_ = false, any_plain_ = false;  ///< compressed chunks, messages outside of them were met
  std::uint64_t chunkless_from_ = 0;                 ///< a search from here on has found no chunk
  std::optional<std::int64_t> last_t_ns_;
  std::vector<Loss> losses_;
  std::size_t dated_ = 0;  ///< losses behind which a message has come
  std::vector<std::string> remarks_, damages_;
  std::size_t unknown_ = 0;  ///< messages of channels that nothing introduces
  const Wanted* wanted_ = nullptr;
  const Visitor* visitor_ = nullptr;
  std::deque<std::pair<std::uint64_t, std::vector<std::uint8_t>>> recent_;  ///< decompressed chunks
  std::vector<std::uint8_t> packed_,
      walked_;  ///< a chunk as it is stored, and the one that is walked through
};

}  // namespace limber::detail
