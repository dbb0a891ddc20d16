// SPDX-License-Identifier: MIT
// MCAP files: https://mcap.dev/spec
#include <fmt/format.h>

#include <cstdlib>
#include <limits>
#include <map>
#include <optional>
#include <vector>

#include "chunked_bag.hpp"
#include "mcap_records.hpp"
#include "openers.hpp"

namespace limber::detail {
namespace {

constexpr std::uint64_t kRecordHead = 9;                                 // opcode and length
constexpr std::uint64_t kFooterContent = 20;                             // two places and a checksum
constexpr std::uint64_t kMessageHead = 22;                               // channel, sequence, two times
constexpr std::uint64_t kLargestMcapDefinition = 1 << 24;                // [bytes] of a schema or a channel
constexpr std::uint64_t kLargestChunkHead = 8 + 8 + 8 + 4 + 4 + 64 + 8;  // "compression" is a short word

struct McapRecord {
  std::uint8_t op;
  std::uint64_t at, size;  // of the content
};

McapRecord mcap_record_at(ByteSource& bytes, std::uint64_t at) {
  FieldReader reader(bytes.view(at, kRecordHead));
  const auto op = reader.integer<std::uint8_t>();
  return {op, at + kRecordHead, reader.integer<std::uint64_t>()};
}

Bytes definition(ByteSource& bytes, const McapRecord& record) {
  if (record.size > kLargestMcapDefinition) {
    throw Damage(fmt::format("a definition of {} bytes", record.size));
  }
  return bytes.view(record.at, record.size);
}

class McapFile final : public ChunkedBag {
 public:
  using ChunkedBag::ChunkedBag;
  [[nodiscard]] std::string format() const override { return "MCAP"; }

 private:
  void read_index() override;
  [[nodiscard]] Place whole_file() override {
    ended_ = false;
    return {file_, mcap::kMagic.size(), file_.size(), nullptr, false};
  }
  void walked() override;
  [[nodiscard]] std::uint64_t step(const Place& place, std::uint64_t at) override;
  [[nodiscard]] std::uint64_t find_record(const Place& place, std::uint64_t from, std::uint64_t end,
                                          bool chunks_only) override;
  [[nodiscard]] bool is_record(const Place& place, std::uint64_t at, bool chunks_only);
  [[nodiscard]] bool is_message(const Place& place, const McapRecord& record);
  [[nodiscard]] bool may_follow(const Place& place, std::uint64_t at);
  [[nodiscard]] ChunkHead chunk_at(std::uint64_t at) override {
    return head_of(mcap_record_at(file_, at), at);
  }
  /// @throws Damage also for what is no chunk
  [[nodiscard]] ChunkHead head_of(const McapRecord& record, std::uint64_t at);
  void take(const Place& place, const McapRecord& record, std::uint64_t at);
  void add_schema(ByteSource& bytes, const McapRecord& record);
  void add_mcap_channel(ByteSource& bytes, const McapRecord& record);
  void visit_message(const Place& place, const McapRecord& record);

  std::map<std::uint16_t, std::string> types_;  // of schemas
  bool ended_ = false;                          // the record that ends the data has been met
};

ChunkHead McapFile::head_of(const McapRecord& record, std::uint64_t at) {
  if (record.op != mcap::kChunk || record.at > file_.size()) {
    throw Damage("another record than a chunk");
  }
  FieldReader reader(
      file_.view(record.at, std::min({kLargestChunkHead, record.size, file_.size() - record.at})));
  ChunkHead head;
  head.at = at;
  (void)reader.take(16);  // first and last time
  head.size = reader.integer<std::uint64_t>();
  head.crc = reader.integer<std::uint32_t>();
  head.compression = reader.text();
  head.content_size = reader.integer<std::uint64_t>();
  head.content_at = record.at + reader.at();
  if (head.content_size > record.size - reader.at()) {
    throw Damage(fmt::format("a chunk of {} bytes in a record of {}", head.content_size, record.size));
  }
  if (!head.is_compressed()) {  // then it is read as far as it goes
    head.content_size = std::min(head.content_size, file_.size() - head.content_at);
  }
  return head;
}

void McapFile::add_schema(ByteSource& bytes, const McapRecord& record) {
  FieldReader reader(definition(bytes, record));
  const auto id = reader.integer<std::uint16_t>();
  types_[id] = without_msg(reader.text());
}

void McapFile::add_mcap_channel(ByteSource& bytes, const McapRecord& record) {
  FieldReader reader(definition(bytes, record));
  const auto id = reader.integer<std::uint16_t>();
  const auto schema = reader.integer<std::uint16_t>();
  const std::string topic = reader.text(), encoding = reader.text();
  const auto type = types_.find(schema);
  add_channel(id, {topic, type == types_.end() ? "" : type->second, serialization_from(encoding), encoding});
}

void McapFile::visit_message(const Place& place, const McapRecord& record) {
  if (record.size < kMessageHead) {
    throw Damage(fmt::format("a message record of {} bytes", record.size));
  }
  FieldReader reader(place.bytes.view(record.at, kMessageHead));
  const auto channel = reader.integer<std::uint16_t>();
  (void)reader.take(4);  // sequence
  const auto t_ns = static_cast<std::int64_t>(reader.integer<std::uint64_t>());
  visit(place, channel, t_ns, record.at + kMessageHead, record.size - kMessageHead);
}

void McapFile::take(const Place& place, const McapRecord& record, std::uint64_t at) {
  switch (record.op) {
    case mcap::kSchema:
      add_schema(place.bytes, record);
      break;
    case mcap::kChannel:
      add_mcap_channel(place.bytes, record);
      break;
    case mcap::kMessage:
      visit_message(place, record);
      break;
    case mcap::kChunk:
      if (place.in_chunk) {
        throw Damage("a chunk within a chunk");
      }
      walk_chunk(head_of(record, at));
      break;
    default:
      if (record.op == 0 || (record.op > mcap::kDataEnd && record.op < mcap::kFirstPrivate)) {
        throw Damage(fmt::format("the opcode {}", record.op));
      }
      break;  // indices, attachments, metadata, and what is private
  }
}

std::uint64_t McapFile::step(const Place& place, std::uint64_t at) {
  const McapRecord record = mcap_record_at(place.bytes, at);
  const bool is_chunk = record.op == mcap::kChunk;
  if (record.at > place.end || (record.size > place.end - record.at && !is_chunk)) {
    throw Damage(fmt::format("{} bytes are missing at its end", record.size - (place.end - record.at)));
  }
  const bool ends = record.op == mcap::kDataEnd || record.op == mcap::kFooter;
  const auto chunk = place.in_chunk ? std::nullopt : next_chunk(at);
  if (chunk && (ends || record.at > *chunk || record.size > *chunk - record.at)) {
    throw Damage(fmt::format("one that ends the data before, or runs into, the chunk at byte {}", *chunk));
  }
  if (!place.in_chunk && is_chunk_by_index(at) && !is_chunk) {
    throw Damage("another one than the chunk that the index says is here");
  }
  if (ends && record.size != (record.op == mcap::kDataEnd ? 4 : kFooterContent)) {
    throw Damage(fmt::format("an end of the data of {} bytes", record.size));
  }
  take(place, record, at);
  ended_ = ended_ || ends;
  if (record.size > std::numeric_limits<std::uint64_t>::max() - record.at) {
    throw Damage(fmt::format("a record of {} bytes", record.size));
  }
  return ends ? place.end : record.at + record.size;
}

void McapFile::walked() {
  if (!ended_ && is_whole()) {
    remark("the file was not closed; what was written until then is read");
  }
}

void McapFile::read_index() {
  types_.clear();
  constexpr std::uint64_t kTail = kRecordHead + kFooterContent + mcap::kMagic.size();
  if (file_.size() < mcap::kMagic.size() + kTail) {
    return;
  }
  const std::uint64_t end = file_.size() - kTail;
  const McapRecord footer = mcap_record_at(file_, end);
  if (footer.op != mcap::kFooter || footer.size != kFooterContent) {
    return;
  }
  auto at = FieldReader(file_.view(footer.at, kFooterContent)).integer<std::uint64_t>();
  while (at > 0 && at < end) {
    const McapRecord record = mcap_record_at(file_, at);
    if (record.op == mcap::kSchema) {
      add_schema(file_, record);
    } else if (record.op == mcap::kChannel) {
      add_mcap_channel(file_, record);
    } else if (record.op == mcap::kChunkIndex) {
      FieldReader reader(definition(file_, record));
      (void)reader.take(16);  // first and last time
      add_chunk(reader.integer<std::uint64_t>());
    }
    if (record.size > end - record.at) {
      return;
    }
    at = record.at + record.size;
  }
}

/// Whether at byte `at` the place ends, or a record begins that may stand there.
bool McapFile::may_follow(const Place& place, std::uint64_t at) {
  if (at == place.end) {
    return true;
  }
  const McapRecord record = mcap_record_at(place.bytes, at);
  return record.op >= mcap::kHeader && record.op <= mcap::kDataEnd && record.at <= place.end &&
         record.size <= place.end - record.at;
}

bool McapFile::is_message(const Place& place, const McapRecord& record) {
  constexpr std::int64_t kDay = 86'400'000'000'000;
  FieldReader reader(place.bytes.view(record.at, kMessageHead));
  const auto channel = reader.integer<std::uint16_t>();
  (void)reader.take(4);  // sequence
  const auto t_ns = static_cast<std::int64_t>(reader.integer<std::uint64_t>());
  const std::int64_t near = last_time().value_or(t_ns);
  return knows(channel) && t_ns >= 0 && near >= 0 && std::abs(t_ns - near) < kDay;
}

bool McapFile::is_record(const Place& place, std::uint64_t at, bool chunks_only) {
  try {
    const McapRecord record = mcap_record_at(place.bytes, at);
    if (record.at > place.end || record.size > place.end - record.at || record.size < kMessageHead) {
      return false;
    }
    if (record.op == mcap::kChunk && !place.in_chunk) {
      const ChunkHead head = head_of(record, at);
      return head.content_at + head.content_size == record.at + record.size;
    }
    return record.op == mcap::kMessage && !chunks_only && is_message(place, record) &&
           may_follow(place, record.at + record.size);
  } catch (const Damage&) {
    return false;
  }
}

// Records begin with nothing that other bytes could not be, so what follows must fit as well.
std::uint64_t McapFile::find_record(const Place& place, std::uint64_t from, std::uint64_t end,
                                    bool chunks_only) {
  constexpr std::uint64_t kStep = 4096;
  for (std::uint64_t at = from; at < end; at += kStep) {
    const Bytes view = place.bytes.view(at, std::min(kStep, end - at));
    const std::vector<std::uint8_t> part(view.begin(), view.end());  // what follows moves the view
    for (std::size_t k = 0; k < part.size(); ++k) {
      if ((part[k] == mcap::kChunk || part[k] == mcap::kMessage) && is_record(place, at + k, chunks_only)) {
        return at + k;
      }
    }
  }
  return end;
}

}  // namespace

std::unique_ptr<BagFile> open_mcap(const std::filesystem::path& path) {
  return std::make_unique<McapFile>(path);
}

}  // namespace limber::detail
