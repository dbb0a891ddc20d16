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
  void walk_file() override;
  void walk_records(const Place& place) override;
  [[nodiscard]] ChunkHead chunk_at(std::uint64_t at) override { return head_of(record_at(file_, at), at); }
  [[nodiscard]] ChunkHead head_of(const Record& record, std::uint64_t at) const;
  void take(const Place& place, const Record& record, std::uint64_t at);
  void add_connection(ByteSource& bytes, const Record& record);
};

ChunkHead Ros1Bag::head_of(const Record& record, std::uint64_t at) const {
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
      if (&place.bytes != &file_ || place.begin != kMagicSize) {
        throw Damage("a chunk within a chunk");
      }
      walk_chunk(head_of(record, at));
      break;
    default:  // the bag's header and the index, which is not needed
      break;
  }
}

void Ros1Bag::walk_records(const Place& place) {
  std::uint64_t at = place.begin;
  while (at < place.end) {
    const Record record = record_at(place.bytes, at);
    const std::uint64_t next = record.data_at + record.data_size;
    if (next > place.end) {
      throw Damage(fmt::format("{} bytes are missing at the end of its last record", next - place.end));
    }
    take(place, record, at);
    at = next;
  }
}

void Ros1Bag::read_index() {
  auto at = record_at(file_, kMagicSize).fields.integer<std::uint64_t>("index_pos");  // 0: never closed
  while (at > kMagicSize && at < file_.size()) {
    const Record record = record_at(file_, at);
    if (record.fields.integer<std::uint8_t>("op") == ros1::kConnection) {
      add_connection(file_, record);
    }
    at = record.data_at + record.data_size;
  }
}

void Ros1Bag::walk_file() {
  const Place whole{file_, kMagicSize, file_.size(), nullptr};
  std::uint64_t at = kMagicSize;
  try {
    while (at < whole.end) {
      const Record record = record_at(file_, at);
      take(whole, record, at);
      at = record.data_at + record.data_size;
    }
    if (at > whole.end) {
      throw Damage(fmt::format("{} bytes are missing at its end", at - whole.end));
    }
  } catch (const Damage& damage) {
    damaged(at, fmt::format("a damaged record, {}; what follows is left out", damage.what()));
  }
}

}  // namespace

std::unique_ptr<BagFile> open_ros1_bag(const std::filesystem::path& path) {
  return std::make_unique<Ros1Bag>(path);
}

}  // namespace limber::detail
