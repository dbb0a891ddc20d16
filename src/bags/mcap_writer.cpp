// SPDX-License-Identifier: MIT
#include "mcap_writer.hpp"

#include <algorithm>

#include "decompress.hpp"
#include "mcap_records.hpp"

namespace limber::detail {
namespace {

constexpr std::size_t kChunkSize = std::size_t{1} << 22;  // [bytes]

/// Little-endian fields.
class McapFields {
 public:
  template <typename Integer>
  McapFields& integer(Integer value) {
    for (std::size_t k = 0; k < sizeof(Integer); ++k) {
      bytes_.push_back(static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * k)));
    }
    return *this;
  }
  McapFields& text(std::string_view text) {
    integer(static_cast<std::uint32_t>(text.size()));
    bytes_.append(text);
    return *this;
  }
  McapFields& raw(std::string_view bytes) {
    bytes_.append(bytes);
    return *this;
  }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }
  /// As a record: opcode, length, content.
  [[nodiscard]] std::string record(mcap::Op op) const {
    return McapFields()
        .integer(static_cast<std::uint8_t>(op))
        .integer(std::uint64_t{bytes_.size()})
        .raw(bytes_)
        .bytes();
  }

 private:
  std::string bytes_;
};

/// A map or array of pairs of integers, behind its length in bytes.
template <typename Pairs>
std::string pairs_text(const Pairs& pairs) {
  McapFields content;
  for (const auto& [a, b] : pairs) {
    content.integer(a).integer(b);
  }
  return McapFields().text(content.bytes()).bytes();
}

Bytes as_bytes(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

std::string_view as_text(Bytes bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

}  // namespace

McapWriter::McapWriter(const std::filesystem::path& path) : file_(path) {
  put(std::string(mcap::kMagic));
  put(McapFields().text("ros2").text("limber").record(mcap::kHeader));
}

void McapWriter::put(const std::string& bytes) {
  file_.write(bytes);
  at_ += bytes.size();
}

std::uint16_t McapWriter::channel(const std::string& topic, const std::string& type,
                                  std::string_view definition) {
  if (const auto known = channels_.find(topic); known != channels_.end()) {
    return known->second;
  }
  const auto [schema, is_new] = schemas_.try_emplace(type, static_cast<std::uint16_t>(schemas_.size() + 1));
  if (is_new) {
    definitions_.push_back(McapFields()
                               .integer(schema->second)
                               .text(type)
                               .text("ros2msg")
                               .text(definition)
                               .record(mcap::kSchema));
    chunk_ += definitions_.back();
  }
  const auto id = static_cast<std::uint16_t>(channels_.size() + 1);
  channels_[topic] = id;
  definitions_.push_back(McapFields()
                             .integer(id)
                             .integer(schema->second)
                             .text(topic)
                             .text("cdr")
                             .integer(std::uint32_t{0})  // no metadata
                             .record(mcap::kChannel));
  chunk_ += definitions_.back();
  return id;
}

void McapWriter::message(std::uint16_t channel, std::int64_t t_ns, Bytes content) {
  const auto time = static_cast<std::uint64_t>(t_ns);
  first_ns_ = entries_.empty() ? time : std::min(first_ns_, time);
  last_ns_ = entries_.empty() ? time : std::max(last_ns_, time);
  entries_[channel].emplace_back(time, chunk_.size());
  const auto sequence = static_cast<std::uint32_t>(counts_[channel]++);
  chunk_ += McapFields()
                .integer(channel)
                .integer(sequence)
                .integer(time)
                .integer(time)
                .raw(as_text(content))
                .record(mcap::kMessage);
  if (chunk_.size() >= kChunkSize) {
    end_chunk();
  }
}

void McapWriter::end_chunk() {
  if (chunk_.empty()) {
    return;
  }
  const auto packed = compress_zstd(as_bytes(chunk_));
  Chunk chunk{first_ns_, last_ns_, at_, 0, 0, packed.size(), chunk_.size(), {}};
  put(McapFields()
          .integer(first_ns_)
          .integer(last_ns_)
          .integer(std::uint64_t{chunk_.size()})
          .integer(crc32_of(as_bytes(chunk_)))
          .text("zstd")
          .integer(std::uint64_t{packed.size()})
          .raw(as_text(packed))
          .record(mcap::kChunk));
  chunk.size = at_ - chunk.at;
  for (const auto& [channel, entries] : entries_) {
    chunk.indices[channel] = at_;
    put(McapFields().integer(channel).raw(pairs_text(entries)).record(mcap::kMessageIndex));
  }
  chunk.index_size = at_ - chunk.at - chunk.size;
  chunks_.push_back(std::move(chunk));
  chunk_.clear();
  entries_.clear();
  first_ns_ = last_ns_ = 0;
}

void McapWriter::write_summary() {
  std::uint64_t messages = 0, first = 0, last = 0;
  for (const auto& [channel, count] : counts_) {
    messages += count;
  }
  for (const Chunk& chunk : chunks_) {
    first = first == 0 ? chunk.first_ns : std::min(first, chunk.first_ns);
    last = std::max(last, chunk.last_ns);
  }
  for (const std::string& definition : definitions_) {
    put(definition);
  }
  put(McapFields()
          .integer(messages)
          .integer(static_cast<std::uint16_t>(schemas_.size()))
          .integer(static_cast<std::uint32_t>(channels_.size()))
          .integer(std::uint32_t{0})  // attachments
          .integer(std::uint32_t{0})  // metadata
          .integer(static_cast<std::uint32_t>(chunks_.size()))
          .integer(first)
          .integer(last)
          .raw(pairs_text(counts_))
          .record(mcap::kStatistics));
  for (const Chunk& chunk : chunks_) {
    put(McapFields()
            .integer(chunk.first_ns)
            .integer(chunk.last_ns)
            .integer(chunk.at)
            .integer(chunk.size)
            .raw(pairs_text(chunk.indices))
            .integer(chunk.index_size)
            .text("zstd")
            .integer(chunk.packed)
            .integer(chunk.unpacked)
            .record(mcap::kChunkIndex));
  }
}

void McapWriter::close() {
  end_chunk();
  put(McapFields()
          .integer(std::uint32_t{0})
          .record(mcap::kDataEnd));  // no checksum of the whole: chunks have one
  const std::uint64_t summary = at_;
  write_summary();
  put(McapFields()
          .integer(summary)
          .integer(std::uint64_t{0})
          .integer(std::uint32_t{0})
          .record(mcap::kFooter));
  put(std::string(mcap::kMagic));
  file_.commit();
}

}  // namespace limber::detail
