// SPDX-License-Identifier: MIT
// MCAP files: https://mcap.dev/spec
#include <fmt/format.h>

#include <map>
#include <optional>

#include "chunked_bag.hpp"
#include "mcap_records.hpp"
#include "openers.hpp"

namespace limber::detail {
namespace {

constexpr std::uint64_t kRecordHead = 9;                                 // opcode and length
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
  void walk_file() override;
  void walk_records(const Place& place) override;
  [[nodiscard]] ChunkHead chunk_at(std::uint64_t at) override {
    return head_of(mcap_record_at(file_, at), at);
  }
  [[nodiscard]] ChunkHead head_of(const McapRecord& record, std::uint64_t at);
  void take(const Place& place, const McapRecord& record, std::uint64_t at);
  void add_schema(ByteSource& bytes, const McapRecord& record);
  void add_mcap_channel(ByteSource& bytes, const McapRecord& record);
  void visit_message(const Place& place, const McapRecord& record);

  std::map<std::uint16_t, std::string> types_;  // of schemas
};

ChunkHead McapFile::head_of(const McapRecord& record, std::uint64_t at) {
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
      if (&place.bytes != &file_ || place.begin != mcap::kMagic.size()) {
        throw Damage("a chunk within a chunk");
      }
      walk_chunk(head_of(record, at));
      break;
    case 0:
      throw Damage("the opcode 0");
    default:  // indices, attachments, metadata, and what later versions may add
      break;
  }
}

void McapFile::walk_records(const Place& place) {
  std::uint64_t at = place.begin;
  while (at < place.end) {
    const McapRecord record = mcap_record_at(place.bytes, at);
    if (record.size > place.end - record.at) {
      throw Damage(fmt::format("{} bytes are missing at the end of its last record",
                               record.size - (place.end - record.at)));
    }
    take(place, record, at);
    at = record.at + record.size;
  }
}

void McapFile::read_index() {
  types_.clear();
  constexpr std::uint64_t kFooterContent = 20;  // where the summary begins, where its offsets begin, CRC
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
    }
    if (record.size > end - record.at) {
      return;
    }
    at = record.at + record.size;
  }
}

void McapFile::walk_file() {
  const Place whole{file_, mcap::kMagic.size(), file_.size(), nullptr};
  std::uint64_t at = whole.begin;
  bool ended = false;
  try {
    while (!ended && at < whole.end) {
      const McapRecord record = mcap_record_at(file_, at);
      take(whole, record, at);
      ended = record.op == mcap::kDataEnd || record.op == mcap::kFooter;
      if (record.size > whole.end - record.at) {
        throw Damage(fmt::format("{} bytes are missing at its end", record.size - (whole.end - record.at)));
      }
      at = record.at + record.size;
    }
    if (!ended) {
      damaged(at, "the file was not closed; what was written until then is read");
    }
  } catch (const Damage& damage) {
    damaged(at, fmt::format("a damaged record, {}; what follows is left out", damage.what()));
  }
}

}  // namespace

std::unique_ptr<BagFile> open_mcap(const std::filesystem::path& path) {
  return std::make_unique<McapFile>(path);
}

}  // namespace limber::detail
