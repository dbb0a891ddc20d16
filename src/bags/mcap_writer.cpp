// SPDX-License-Identifier: MIT
#include "mcap_writer.hpp"

#include <algorithm>

#include "compress.hpp"
#include "decompress.hpp"
#include "field_writer.hpp"
#include "mcap_records.hpp"

namespace limber::detail {
namespace {

constexpr std::size_t kMcapChunkSize = std::size_t{1} << 22;  // [bytes]

/// A record: opcode, length, content.
std::string mcap_record(mcap::Op op, const FieldWriter& content) {
  return FieldWriter()
      .integer(static_cast<std::uint8_t>(op))
      .integer(std::uint64_t{content.bytes().size()})
      .raw(content.bytes())
      .bytes();
}

/// A map or array of pairs of integers, behind its length in bytes.
template <typename Pairs>
std::string pairs_text(const Pairs& pairs) {
  FieldWriter content;
  for (const auto& [a, b] : pairs) {
    content.integer(a).integer(b);
  }
  return FieldWriter().text(content.bytes()).bytes();
}

}  // namespace

McapWriter::McapWriter(const std::filesystem::path& path, std::string compression)
    : file_(path), compression_(std::move(compression)) {
  put(std::string(mcap::kMagic));
  put(mcap_record(mcap::kHeader, FieldWriter().text("ros2").text("limber")));
}

void McapWriter::put(const std::string& bytes) {
  file_.write(bytes);
  at_ += bytes.size();
}

std::uint16_t McapWriter::channel(const std::string& topic, const MessageType& type, bool) {
  if (const auto known = channels_.find(topic); known != channels_.end()) {
    return known->second;
  }
  const auto [schema, is_new] =
      schemas_.try_emplace(full_name(type, serialization()), static_cast<std::uint16_t>(schemas_.size() + 1));
  if (is_new) {
    definitions_.push_back(mcap_record(mcap::kSchema, FieldWriter()
                                                          .integer(schema->second)
                                                          .text(schema->first)
                                                          .text("ros2msg")
                                                          .text(definition_of(type, serialization()))));
    chunk_ += definitions_.back();
  }
  const auto id = static_cast<std::uint16_t>(channels_.size() + 1);
  channels_[topic] = id;
  definitions_.push_back(mcap_record(mcap::kChannel, FieldWriter()
                                                         .integer(id)
                                                         .integer(schema->second)
                                                         .text(topic)
                                                         .text("cdr")
                                                         .integer(std::uint32_t{0})));  // no metadata
  chunk_ += definitions_.back();
  return id;
}

void McapWriter::message(std::uint16_t channel, std::int64_t t_ns, Bytes content) {
  const auto time = static_cast<std::uint64_t>(t_ns);
  first_ns_ = entries_.empty() ? time : std::min(first_ns_, time);
  last_ns_ = entries_.empty() ? time : std::max(last_ns_, time);
  entries_[channel].emplace_back(time, chunk_.size());
  const auto sequence = static_cast<std::uint32_t>(counts_[channel]++);
  chunk_ += mcap_record(
      mcap::kMessage,
      FieldWriter().integer(channel).integer(sequence).integer(time).integer(time).raw(as_text(content)));
  if (chunk_.size() >= kMcapChunkSize) {
    end_chunk();
  }
}

void McapWriter::end_chunk() {
  if (chunk_.empty()) {
    return;
  }
  const std::string packed = compress(compression_, chunk_);
  Chunk chunk{first_ns_, last_ns_, at_, 0, 0, packed.size(), chunk_.size(), {}};
  put(mcap_record(mcap::kChunk, FieldWriter()
                                    .integer(first_ns_)
                                    .integer(last_ns_)
                                    .integer(std::uint64_t{chunk_.size()})
                                    .integer(crc32_of(as_bytes(chunk_)))
                                    .text(compression_ == "none" ? "" : compression_)
                                    .integer(std::uint64_t{packed.size()})
                                    .raw(packed)));
  chunk.size = at_ - chunk.at;
  for (const auto& [channel, entries] : entries_) {
    chunk.indices[channel] = at_;
    put(mcap_record(mcap::kMessageIndex, FieldWriter().integer(channel).raw(pairs_text(entries))));
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
  put(mcap_record(mcap::kStatistics, FieldWriter()
                                         .integer(messages)
                                         .integer(static_cast<std::uint16_t>(schemas_.size()))
                                         .integer(static_cast<std::uint32_t>(channels_.size()))
                                         .integer(std::uint32_t{0})  // attachments
                                         .integer(std::uint32_t{0})  // metadata
                                         .integer(static_cast<std::uint32_t>(chunks_.size()))
                                         .integer(first)
                                         .integer(last)
                                         .raw(pairs_text(counts_))));
  for (const Chunk& chunk : chunks_) {
    put(mcap_record(mcap::kChunkIndex, FieldWriter()
                                           .integer(chunk.first_ns)
                                           .integer(chunk.last_ns)
                                           .integer(chunk.at)
                                           .integer(chunk.size)
                                           .raw(pairs_text(chunk.indices))
                                           .integer(chunk.index_size)
                                           .text(compression_ == "none" ? "" : compression_)
                                           .integer(chunk.packed)
                                           .integer(chunk.unpacked)));
  }
}

void McapWriter::close() {
  end_chunk();
  put(mcap_record(mcap::kDataEnd,
                  FieldWriter().integer(std::uint32_t{0})));  // no checksum of the whole: chunks have one
  const std::uint64_t summary = at_;
  write_summary();
  put(mcap_record(mcap::kFooter,
                  FieldWriter().integer(summary).integer(std::uint64_t{0}).integer(std::uint32_t{0})));
  put(std::string(mcap::kMagic));
  file_.commit();
}

}  // namespace limber::detail
