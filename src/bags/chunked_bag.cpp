// SPDX-License-Identifier: MIT
#include "chunked_bag.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>

#include "decompress.hpp"
#include "limber/core/errors.hpp"
#include "loss.hpp"

namespace limber::detail {
namespace {

constexpr std::size_t kRecentChunks = 3;  // left and right image alternate, often between two chunks

}  // namespace

void ChunkedBag::walk(const Wanted& wanted, const Visitor& visitor) {
  const auto forget = [this] {
    topics_.clear();
    wanted_bytes_.clear();
    channels_.clear();
    chunks_.clear();
    sound_chunks_.clear();
  };
  forget();
  damages_.clear();
  losses_.clear();
  remarks_.clear();
  dated_ = unknown_ = 0;
  any_compressed_ = any_plain_ = false;
  chunkless_from_ = file_.size();
  last_chunk_.reset();
  last_t_ns_.reset();
  wanted_ = &wanted;
  visitor_ = &visitor;
  try {
    read_index();
  } catch (const Damage&) {
    forget();  // the messages are walked through all the same, and introduce their channels
  }
  std::sort(chunks_.begin(), chunks_.end());
  chunks_.erase(std::unique(chunks_.begin(), chunks_.end()), chunks_.end());
  std::copy_if(chunks_.begin(), chunks_.end(), std::back_inserter(sound_chunks_),
               [this](std::uint64_t at) { return is_sound_chunk(at); });
  walk_records(whole_file());
  walked();
  tell_damages();
}

bool ChunkedBag::is_sound_chunk(std::uint64_t at) {
  try {
    any_compressed_ = chunk_at(at).is_compressed() || any_compressed_;
    return true;
  } catch (const Damage&) {
    return false;
  }
}

std::optional<std::uint64_t> ChunkedBag::next_chunk(std::uint64_t at) const {
  const auto next = std::upper_bound(sound_chunks_.begin(), sound_chunks_.end(), at);
  return next == sound_chunks_.end() ? std::nullopt : std::optional(*next);
}

bool ChunkedBag::is_chunk_by_index(std::uint64_t at) const {
  return std::binary_search(chunks_.begin(), chunks_.end(), at);
}

void ChunkedBag::walk_records(const Place& place) {
  std::uint64_t before = place.begin, at = place.begin;
  while (at < place.end) {
    try {
      const std::uint64_t next = step(place, at);
      if (next > place.end) {
        throw Damage(fmt::format("{} bytes are missing at its end", next - place.end));
      }
      before = at;
      at = next;
    } catch (const Damage& damage) {
      const std::uint64_t next = resume(place, before, at);
      const std::uint64_t from =
          next > at ? at : before;  // else the one before claimed to be longer than it is
      note_damage(place, from, next - from, damage.what());
      before = at = next;
    }
  }
}

void ChunkedBag::note_damage(const Place& place, std::uint64_t at, std::uint64_t bytes,
                             std::string_view what) {
  const bool told = last_chunk_ == at && !losses_.empty() && losses_.back().at >= at && !losses_.back().after;
  if (place.chunk != nullptr) {
    lost(place.chunk->at, bytes, fmt::format("a damaged record in a chunk, {}", what));
  } else if (!told) {  // the end of a chunk that was cut off, and the chunk itself
    lost(at, bytes, fmt::format("a damaged record, {}", what));
  }
}

bool ChunkedBag::may_hold_messages(std::uint64_t chunk, std::uint64_t end) {
  if (any_compressed_) {  // then what looks like a message is a part of a compressed one
    return false;
  }
  return chunk < end ? !chunk_at(chunk).is_compressed() : any_plain_;
}

std::uint64_t ChunkedBag::find_other(const Place& place, std::uint64_t from, std::uint64_t end,
                                     std::uint64_t not_at, bool chunks_only) {
  const std::uint64_t found = find_record(place, from, end, chunks_only);
  return found == not_at ? find_record(place, not_at + 1, end, chunks_only) : found;
}

std::uint64_t ChunkedBag::resume(const Place& place, std::uint64_t before, std::uint64_t at) {
  if (place.in_chunk) {
    return find_other(place, before + 1, place.end, at, false);
  }
  const std::uint64_t end = next_chunk(at).value_or(place.end);
  const bool cut_off = last_chunk_ == at;  // as far as it went it has been read
  // Of a chunk, too, but it may have claimed to be longer than it is, and so may any other record.
  const std::uint64_t from = cut_off ? at + 1 : before + 1;
  std::uint64_t chunk = end;
  if (from < chunkless_from_) {
    chunk = find_other(place, from, end, at, true);
    chunkless_from_ = chunk == place.end ? from : chunkless_from_;
  }
  if (cut_off || (last_chunk_ == before && chunk < at) || !may_hold_messages(chunk, place.end)) {
    return chunk;
  }
  return find_other(place, last_chunk_ == before ? at + 1 : from, end, at, false);
}

void ChunkedBag::lost(std::uint64_t at, std::uint64_t bytes, std::string what) {
  losses_.push_back({at, bytes, std::move(what), last_t_ns_, std::nullopt});
}

void ChunkedBag::tell_damages() {
  const std::string file = file_.path().string();
  for (const Loss& loss : losses_) {
    if (damages_.size() == kMostDamages) {
      break;
    }
    damages_.push_back(fmt::format("{}, byte {}: {}; {} bytes are left out{}", file, loss.at, loss.what,
                                   loss.bytes, when_lost(loss.before, loss.after)));
  }
  if (losses_.size() > kMostDamages) {
    std::uint64_t bytes = 0;
    for (std::size_t k = kMostDamages; k < losses_.size(); ++k) {
      bytes += losses_[k].bytes;
    }
    damages_.push_back(
        fmt::format("{}: {} more damaged places of {} bytes", file, losses_.size() - kMostDamages, bytes));
  }
  if (unknown_ > 0) {
    damages_.push_back(
        fmt::format("{}: {} messages of topics that nothing introduces are left out", file, unknown_));
  }
  for (const std::string& text : remarks_) {
    damages_.push_back(fmt::format("{}: {}", file, text));
  }
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
  last_t_ns_ = t_ns;
  any_plain_ = any_plain_ || place.chunk == nullptr;
  for (; dated_ < losses_.size(); ++dated_) {
    losses_[dated_].after = t_ns;
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
  last_chunk_ = head.at;
  any_compressed_ = any_compressed_ || head.is_compressed();
  if (!head.is_compressed()) {
    walk_records({file_, head.content_at, head.content_at + head.content_size, nullptr, true});
    return;
  }
  try {
    unpack(head, walked_);
  } catch (const Damage& damage) {
    lost(head.at, head.content_size, fmt::format("a damaged chunk, {}", damage.what()));
    return;
  }
  MemoryBytes bytes(walked_);
  walk_records({bytes, 0, walked_.size(), &head, true});
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
