// SPDX-License-Identifier: MIT
#include "chunked_bag.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "decompress.hpp"
#include "limber/core/errors.hpp"

namespace limber::detail {
namespace {

constexpr std::size_t kRecentChunks = 3;  // left and right image alternate, often between two chunks
constexpr std::size_t kMostDamages = 5;   // that are told one by one

}  // namespace

void ChunkedBag::walk(const Wanted& wanted, const Visitor& visitor) {
  topics_.clear();
  wanted_bytes_.clear();
  channels_.clear();
  damages_.clear();
  more_damages_ = unknown_ = 0;
  wanted_ = &wanted;
  visitor_ = &visitor;
  try {
    read_index();
  } catch (const Damage&) {
    channels_.clear();  // the messages are walked through all the same, and introduce their channels
    topics_.clear();
    wanted_bytes_.clear();
  }
  walk_file();
  if (unknown_ > 0) {
    damages_.push_back(fmt::format("{}: {} messages of topics that nothing introduces are left out",
                                   file_.path().string(), unknown_));
  }
  if (more_damages_ > 0) {
    damages_.push_back(fmt::format("{}: {} more damaged places", file_.path().string(), more_damages_));
  }
}

void ChunkedBag::damaged(std::uint64_t at, std::string_view what) {
  if (damages_.size() == kMostDamages) {
    ++more_damages_;
    return;
  }
  damages_.push_back(fmt::format("{}, byte {}: {}", file_.path().string(), at, what));
}

void ChunkedBag::add_channel(std::uint64_t channel, const BagTopic& topic) {
  if (knows(channel)) {
    return;
  }
  const auto same = std::find_if(topics_.begin(), topics_.end(), [&](const BagTopic& other) {
    return other.name == topic.name && other.type == topic.type &&
           other.serialization_name == topic.serialization_name;
  });
  channels_[channel] = static_cast<std::size_t>(same - topics_.begin());
  if (same == topics_.end()) {
    topics_.push_back(topic);
    wanted_bytes_.push_back((*wanted_)(topic));
  }
}

void ChunkedBag::visit(const Place& place, std::uint64_t channel, std::int64_t t_ns, std::uint64_t at,
                       std::uint64_t size) {
  const auto known = channels_.find(channel);
  if (known == channels_.end()) {
    ++unknown_;
    return;
  }
  const std::size_t count = std::min<std::uint64_t>(wanted_bytes_[known->second], size);
  BagMessage message{known->second, t_ns, {at, 0, size, 0, false}, {}};
  if (place.chunk != nullptr) {
    message.place = {place.chunk->at, at, size, 0, true};
  }
  if (count > 0) {
    message.data = place.bytes.view(at, count);
  }
  (*visitor_)(message);
}

void ChunkedBag::unpack(const ChunkHead& head, std::vector<std::uint8_t>& content) {
  file_.copy(head.content_at, head.content_size, packed_);
  decompress(head.compression, packed_, head.size, content);
  if (head.crc != 0 && crc32_of(content) != head.crc) {
    throw Damage("a chunk whose checksum is wrong");
  }
}

void ChunkedBag::walk_chunk(const ChunkHead& head) {
  try {
    if (!head.is_compressed()) {
      walk_records({file_, head.content_at, head.content_at + head.content_size, nullptr});
      return;
    }
    unpack(head, walked_);
    MemoryBytes bytes(walked_);
    walk_records({bytes, 0, walked_.size(), &head});
  } catch (const Damage& damage) {
    damaged(head.at, fmt::format("a damaged chunk, {}; what follows in it is left out", damage.what()));
  }
}

const std::vector<std::uint8_t>& ChunkedBag::chunk_content(std::uint64_t at) {
  const auto found =
      std::find_if(recent_.begin(), recent_.end(), [&](const auto& chunk) { return chunk.first == at; });
  if (found != recent_.end()) {
    return found->second;
  }
  std::vector<std::uint8_t> content;
  if (recent_.size() == kRecentChunks) {
    content = std::move(recent_.front().second);
    recent_.pop_front();
  }
  unpack(chunk_at(at), content);
  return recent_.emplace_back(at, std::move(content)).second;
}

std::vector<std::uint8_t> ChunkedBag::read(const BagPlace& place) {
  try {
    if (!place.in_chunk) {
      return file_.copy(place.at, place.size);
    }
    const Bytes bytes = MemoryBytes(chunk_content(place.at)).view(place.within, place.size);
    return {bytes.begin(), bytes.end()};
  } catch (const Damage& damage) {
    throw DataError(file_.path().string(), 0, fmt::format("a message at byte {}", place.at), damage.what());
  }
}

}  // namespace limber::detail
