// SPDX-License-Identifier: MIT
// ROS 1 bags, format 2.0: http://wiki.ros.org/Bags/Format/2.0
#include <fmt/format.h>

#include <map>

#include "chunked_bag.hpp"
#include "openers.hpp"
#include "ros1_records.hpp"

namespace limber::detail {
namespace {

constexpr std::uint64_t kMagicSize = ros1::kMagic.size();
constexpr std::uint64_t kLargestHeader = 1 << 20, kLargestDefinition = 1 << 24;  // [bytes]

/// "name=value" fields, each with its length.
class Fields {
 public:
  explicit Fields(Bytes bytes) {
    FieldReader reader(bytes);
    while (!reader.done()) {
      const std::string field = reader.text();
      const std::size_t equals = field.find('=');
      if (equals == std::string::npos) {
        throw Damage("a header field without '='");
      }
      values_[field.substr(0, equals)] = field.substr(equals + 1);
    }
  }

  [[nodiscard]] const std::string& text(const std::string& name) const {
    const auto found = values_.find(name);
    if (found == values_.end()) {
      throw Damage("a header without the field " + name);
    }
    return found->second;
  }
  template <typename Integer>
  [[nodiscard]] Integer integer(const std::string& name) const {
    const std::string& value = text(name);
    if (value.size() != sizeof(Integer)) {
      throw Damage(fmt::format("a field {} of {} bytes", name, value.size()));
    }
    return FieldReader({reinterpret_cast<const std::uint8_t*>(value.data()), value.size()})
        .integer<Integer>();
  }

 private:
  std::map<std::string, std::string> values_;
};

struct Record {
  Fields fields;
  std::uint64_t data_at, data_size;
};

Record record_at(ByteSource& bytes, std::uint64_t at) {
  const auto length_at = [&](std::uint64_t where) {
    return FieldReader(bytes.view(where, 4)).integer<std::uint32_t>();
  };
  const std::uint64_t header_size = length_at(at);
  if (header_size > kLargestHeader) {
    throw Damage(fmt::format("a header of {} bytes", header_size));
  }
  Fields fields(bytes.view(at + 4, header_size));
  const std::uint64_t data_size = length_at(at + 4 + header_size);
  return {std::move(fields), at + 8 + header_size, data_size};
}

class Ros1Bag final : public ChunkedBag {
 public:
  using ChunkedBag::ChunkedBag;
  [[nodiscard]] std::string format() const override { return "ROS 1 bag"; }

 private:
  void read_index() override;
  [[nodiscard]] Place whole_file() override { return {file_, kMagicSize, file_.size(), nullptr, false}; }
  [[nodiscard]] std::uint64_t step(const Place& place, std::uint64_t at) override;
  [[nodiscard]] std::uint64_t find_record(const Place& place, std::uint64_t from, std::uint64_t end,
                                          bool chunks_only) override;
  [[nodiscard]] bool is_record(const Place& place, std::uint64_t at, bool chunks_only);
  [[nodiscard]] ChunkHead chunk_at(std::uint64_t at) override { return head_of(record_at(file_, at), at); }
  /// @throws Damage also for what is no chunk
  [[nodiscard]] ChunkHead head_of(const Record& record, std::uint64_t at) const;
  void take(const Place& place, const Record& record, std::uint64_t at);
  void add_connection(ByteSource& bytes, const Record& record);
};

ChunkHead Ros1Bag::head_of(const Record& record, std::uint64_t at) const {
  if (record.fields.integer<std::uint8_t>("op") != ros1::kChunk) {
    throw Damage("another record than a chunk");
  }
  ChunkHead head{at,
                 record.fields.text("compression"),
                 record.fields.integer<std::uint32_t>("size"),
                 record.data_at,
                 record.data_size,
                 0};
  if (!head.is_compressed()) {  // then it is read as far as it goes
    head.content_size = std::min(head.content_size, file_.size() - head.content_at);
  }
  return head;
}

void Ros1Bag::add_connection(ByteSource& bytes, const Record& record) {
  const auto connection = record.fields.integer<std::uint32_t>("conn");
  if (knows(connection)) {
    return;
  }
  if (record.data_size > kLargestDefinition) {
    throw Damage(fmt::format("a message definition of {} bytes", record.data_size));
  }
  const std::string topic = record.fields.text("topic");
  const Fields data(bytes.view(record.data_at, record.data_size));
  add_channel(connection, {topic, data.text("type"), Serialization::kRos1, "ros1"});
}

void Ros1Bag::take(const Place& place, const Record& record, std::uint64_t at) {
  switch (record.fields.integer<std::uint8_t>("op")) {
    case ros1::kMessage: {
      const auto time = record.fields.integer<std::uint64_t>("time");  // seconds, then nanoseconds
      visit(place, record.fields.integer<std::uint32_t>("conn"),
            static_cast<std::int64_t>(time & 0xffffffffU) * 1'000'000'000 +
                static_cast<std::int64_t>(time >> 32),
            record.data_at, record.data_size);
      break;
    }
    case ros1::kConnection:
      add_connection(place.bytes, record);
      break;
    case ros1::kChunk:
      if (place.in_chunk) {
        throw Damage("a chunk within a chunk");
      }
      walk_chunk(head_of(record, at));
      break;
    default:  // the bag's header and the index, which is not needed
      break;
  }
}

std::uint64_t Ros1Bag::step(const Place& place, std::uint64_t at) {
  const Record record = record_at(place.bytes, at);
  const std::uint64_t next = record.data_at + record.data_size;
  const bool is_chunk = record.fields.integer<std::uint8_t>("op") == ros1::kChunk;
  if (next > place.end && !is_chunk) {  // a chunk is read as far as it goes
    throw Damage(fmt::format("{} bytes are missing at its end", next - place.end));
  }
  if (!place.in_chunk) {
    if (is_chunk_by_index(at) && !is_chunk) {
      throw Damage("another one than the chunk that the index says is here");
    }
    if (const auto chunk = next_chunk(at); chunk && next > *chunk) {
      throw Damage(fmt::format("one that runs into the chunk at byte {}", *chunk));
    }
  }
  take(place, record, at);
  return next;
}

void Ros1Bag::read_index() {
  auto at = record_at(file_, kMagicSize).fields.integer<std::uint64_t>("index_pos");  // 0: never closed
  while (at > kMagicSize && at < file_.size()) {
    const Record record = record_at(file_, at);
    const auto op = record.fields.integer<std::uint8_t>("op");
    if (op == ros1::kConnection) {
      add_connection(file_, record);
    } else if (op == ros1::kChunkInfo) {
      add_chunk(record.fields.integer<std::uint64_t>("chunk_pos"));
    }
    at = record.data_at + record.data_size;
  }
}

bool Ros1Bag::is_record(const Place& place, std::uint64_t at, bool chunks_only) {
  try {
    const Record record = record_at(place.bytes, at);
    if (record.data_at > place.end || record.data_size > place.end - record.data_at) {
      return false;
    }
    switch (record.fields.integer<std::uint8_t>("op")) {
      case ros1::kChunk:
        (void)record.fields.text("compression");
        (void)record.fields.integer<std::uint32_t>("size");
        return !place.in_chunk;
      case ros1::kMessage:
        (void)record.fields.integer<std::uint64_t>("time");
        return !chunks_only && knows(record.fields.integer<std::uint32_t>("conn"));
      default:
        return false;
    }
  } catch (const Damage&) {
    return false;
  }
}

// A header has the field "op" of five bytes, somewhere in it.
std::uint64_t Ros1Bag::find_record(const Place& place, std::uint64_t from, std::uint64_t end,
                                   bool chunks_only) {
  using namespace std::string_view_literals;
  constexpr std::string_view kField = "\x04\0\0\0op="sv;
  constexpr std::uint64_t kLongestBefore = 256;  // [bytes] of a header, before the field
  for (std::uint64_t at = find_bytes(place.bytes, from, end, kField); at < end;
       at = find_bytes(place.bytes, at + 1, end, kField)) {
    for (std::uint64_t begin = at > from + kLongestBefore ? at - kLongestBefore : from; begin + 4 <= at;
         ++begin) {
      const auto header = FieldReader(place.bytes.view(begin, 4)).integer<std::uint32_t>();
      if (header <= 2 * kLongestBefore && begin + 4 + header > at && is_record(place, begin, chunks_only)) {
        return begin;
      }
    }
  }
  return end;
}

}  // namespace

std::unique_ptr<BagFile> open_ros1_bag(const std::filesystem::path& path) {
  return std::make_unique<Ros1Bag>(path);
}

}  // namespace limber::detail
