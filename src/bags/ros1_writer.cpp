// SPDX-License-Identifier: MIT
#include "ros1_writer.hpp"

#include <algorithm>

#include "compress.hpp"
#include "field_writer.hpp"
#include "ros1_records.hpp"

namespace limber::detail {
namespace {

constexpr std::size_t kRos1ChunkSize = 768 * 1024;  // [bytes] rosbag's own
constexpr std::size_t kBagHeaderSize = 4096;        // [bytes] header and padding of the first record

/// "name=value" fields, each behind its length; the value as its bytes.
class HeaderWriter {
 public:
  explicit HeaderWriter(ros1::Op op) { integer("op", static_cast<std::uint8_t>(op)); }

  template <typename Integer>
  HeaderWriter& integer(std::string_view name, Integer value) {
    return text(name, FieldWriter().integer(value).bytes());
  }
  HeaderWriter& text(std::string_view name, std::string_view value) {
    fields_.text(std::string(name).append("=").append(value));
    return *this;
  }
  [[nodiscard]] std::size_t size() const { return fields_.bytes().size(); }
  /// Both behind their lengths.
  [[nodiscard]] std::string record(std::string_view data) const {
    return FieldWriter().text(fields_.bytes()).text(data).bytes();
  }

 private:
  FieldWriter fields_;
};

/// Seconds, then nanoseconds. Zero is no time of a bag: its readers begin at the first nanosecond.
std::uint64_t bag_time(std::int64_t t_ns) {
  constexpr std::uint64_t kSecond = 1'000'000'000;
  const auto t = static_cast<std::uint64_t>(std::max(t_ns, std::int64_t{1}));
  return t / kSecond | t % kSecond << 32;
}

std::string bag_header(std::uint64_t index_at, std::size_t connections, std::size_t chunks) {
  const HeaderWriter header = HeaderWriter(ros1::kBagHeader)
                                  .integer("index_pos", index_at)
                                  .integer("conn_count", static_cast<std::uint32_t>(connections))
                                  .integer("chunk_count", static_cast<std::uint32_t>(chunks));
  return header.record(std::string(kBagHeaderSize - header.size(), ' '));
}

}  // namespace

Ros1Writer::Ros1Writer(const std::filesystem::path& path, std::string compression)
    : file_(path), compression_(std::move(compression)) {
  put(std::string(ros1::kMagic));
  put(bag_header(0, 0, 0));
}

void Ros1Writer::put(const std::string& bytes) {
  file_.write(bytes);
  at_ += bytes.size();
}

std::uint16_t Ros1Writer::channel(const std::string& topic, const MessageType& type, bool is_latched) {
  const auto [known, is_new] = channels_.try_emplace(topic, static_cast<std::uint16_t>(channels_.size()));
  if (is_new) {
    FieldWriter data;
    const auto field = [&](std::string_view name, std::string_view value) {
      data.text(std::string(name).append("=").append(value));
    };
    field("topic", topic);
    field("type", type.name);
    field("md5sum", type.md5);
    field("message_definition", definition_of(type, serialization()));
    if (is_latched) {
      field("callerid", "/limber");
      field("latching", "1");
    }
    connections_.push_back(HeaderWriter(ros1::kConnection)
                               .integer("conn", std::uint32_t{known->second})
                               .text("topic", topic)
                               .record(data.bytes()));
    content_ += connections_.back();
  }
  return known->second;
}

void Ros1Writer::message(std::uint16_t channel, std::int64_t t_ns, Bytes content) {
  chunk_.first_ns = entries_.empty() ? t_ns : std::min(chunk_.first_ns, t_ns);
  chunk_.last_ns = entries_.empty() ? t_ns : std::max(chunk_.last_ns, t_ns);
  ++chunk_.counts[channel];
  entries_[channel].emplace_back(bag_time(t_ns), static_cast<std::uint32_t>(content_.size()));
  content_ += HeaderWriter(ros1::kMessage)
                  .integer("conn", std::uint32_t{channel})
                  .integer("time", bag_time(t_ns))
                  .record(as_text(content));
  if (content_.size() >= kRos1ChunkSize) {
    end_chunk();
  }
}

void Ros1Writer::end_chunk() {
  if (content_.empty()) {
    return;
  }
  chunk_.at = at_;
  put(HeaderWriter(ros1::kChunk)
          .text("compression", compression_)
          .integer("size", static_cast<std::uint32_t>(content_.size()))
          .record(compress(compression_, content_)));
  for (const auto& [channel, entries] : entries_) {
    FieldWriter places;
    for (const auto& [time, at] : entries) {
      places.integer(time).integer(at);
    }
    put(HeaderWriter(ros1::kIndex)
            .integer("ver", std::uint32_t{1})
            .integer("conn", std::uint32_t{channel})
            .integer("count", static_cast<std::uint32_t>(entries.size()))
            .record(places.bytes()));
  }
  chunks_.push_back(std::move(chunk_));
  chunk_ = {};
  content_.clear();
  entries_.clear();
}

void Ros1Writer::write_index() {
  for (const std::string& connection : connections_) {
    put(connection);
  }
  for (const Chunk& chunk : chunks_) {
    FieldWriter counts;
    for (const auto& [channel, count] : chunk.counts) {
      counts.integer(std::uint32_t{channel}).integer(count);
    }
    put(HeaderWriter(ros1::kChunkInfo)
            .integer("ver", std::uint32_t{1})
            .integer("chunk_pos", chunk.at)
            .integer("start_time", bag_time(chunk.first_ns))
            .integer("end_time", bag_time(chunk.last_ns))
            .integer("count", static_cast<std::uint32_t>(chunk.counts.size()))
            .record(counts.bytes()));
  }
}

void Ros1Writer::close() {
  end_chunk();
  const std::uint64_t index = at_;
  write_index();
  file_.overwrite(ros1::kMagic.size(), bag_header(index, connections_.size(), chunks_.size()));
  file_.commit();
}

}  // namespace limber::detail
