// SPDX-License-Identifier: MIT
#include "sqlite_pages.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace limber::detail {
namespace {

constexpr std::uint8_t kTableLeaf = 0x0d;
constexpr std::uint64_t kLeafHead = 8, kLink = 4;  // [bytes]

std::uint64_t big_endian(Bytes page, std::uint64_t at, std::uint64_t count) {
  std::uint64_t out = 0;
  for (const std::uint8_t byte : page.subspan(at, count)) {
    out = out << 8 | byte;
  }
  return out;
}

/// A number of one to nine bytes that moves `at` on; nothing where the page ends in it.
std::optional<std::uint64_t> varint(Bytes page, std::uint64_t& at) {
  std::uint64_t out = 0;
  for (int k = 0; k < 9; ++k) {
    if (at >= page.size()) {
      return std::nullopt;
    }
    const std::uint8_t byte = page[at++];
    if (k == 8) {
      return out << 8 | byte;
    }
    out = out << 7 | (byte & 0x7f);
    if (byte < 0x80) {
      return out;
    }
  }
  return std::nullopt;
}

/// The integer of a column of type 1 to 6, 8 or 9, which moves `at` on; nothing of another type.
std::optional<std::int64_t> integer(Bytes page, std::uint64_t type, std::uint64_t& at) {
  if (type == 8 || type == 9) {
    return static_cast<std::int64_t>(type - 8);
  }
  constexpr std::uint64_t kSizes[] = {0, 1, 2, 3, 4, 6, 8};
  if (type < 1 || type > 6 || at + kSizes[type] > page.size()) {
    return std::nullopt;
  }
  const std::uint64_t unused = 64 - 8 * kSizes[type];
  const std::uint64_t value = big_endian(page, at, kSizes[type]) << unused;
  at += kSizes[type];
  return static_cast<std::int64_t>(value) >> unused;  // with its sign
}

/// Leaves by rising rows, without those that share rows with another.
std::vector<MessageLeaf> without_twins(std::vector<MessageLeaf> leaves) {
  std::sort(leaves.begin(), leaves.end(),
            [](const auto& a, const auto& b) { return a.front().row < b.front().row; });
  std::vector<MessageLeaf> out;
  std::int64_t last = -1;  // of those before
  for (std::size_t k = 0; k < leaves.size(); ++k) {
    const std::int64_t own_last = leaves[k].back().row;
    const bool before = leaves[k].front().row <= last;
    const bool behind = k + 1 < leaves.size() && leaves[k + 1].front().row <= own_last;
    last = std::max(last, own_last);
    if (!before && !behind) {
      out.push_back(std::move(leaves[k]));
    }
  }
  return out;
}

}  // namespace

/// What stands in a leaf for a row.
struct SqlitePages::Cell {
  MessageRow row;
  std::uint64_t data = 0, local_end = 0;  ///< bytes in the page: the data, and the end of what is on it
  std::uint32_t overflow = 0;             ///< page with what follows; 0: nothing does
};

SqlitePages::SqlitePages(const std::filesystem::path& path) : file_(path) {
  const Bytes head = file_.view(0, 100);
  page_size_ = big_endian(head, 16, 2);
  page_size_ = page_size_ == 1 ? 65'536 : page_size_;
  usable_ = page_size_ - std::min<std::uint64_t>(head[20], page_size_);
  const bool is_power = (page_size_ & (page_size_ - 1)) == 0;
  if (page_size_ < 512 || !is_power || usable_ < 480) {
    throw Damage("an SQLite file with no size of its pages");
  }
  const std::uint64_t pages = file_.size() / page_size_;
  pages_ =
      static_cast<std::uint32_t>(std::min<std::uint64_t>(pages, std::numeric_limits<std::int32_t>::max()));
}

Bytes SqlitePages::page(std::uint32_t number) {
  if (number < 1 || number > pages_) {
    throw Damage("a page that is not in the file");
  }
  return file_.view(start_of(number), page_size_).first(usable_);
}

std::vector<bool> SqlitePages::free_pages() {
  std::vector<bool> out(pages_ + std::size_t{1}, false);
  const Bytes head = file_.view(0, 100);
  auto trunk = static_cast<std::uint32_t>(big_endian(head, 32, 4));
  const std::uint64_t count = big_endian(head, 36, 4);
  std::uint64_t found = 0;
  const auto put = [&](std::uint64_t number) {
    if (number < 2 || number > pages_ || out[number]) {
      throw Damage("a broken list of free pages");
    }
    out[number] = true;
    ++found;
  };
  while (trunk != 0) {
    put(trunk);
    const Bytes list = page(trunk);
    const std::uint64_t listed = big_endian(list, 4, 4);
    for (std::uint64_t k = 0; k < std::min(listed, usable_ / 4 - 2); ++k) {
      put(big_endian(list, 8 + 4 * k, 4));
    }
    trunk = static_cast<std::uint32_t>(big_endian(list, 0, 4));
  }
  if (found != count) {
    throw Damage("a broken list of free pages");
  }
  return out;
}

std::uint64_t SqlitePages::local_size(std::uint64_t payload) const {
  if (payload <= usable_ - 35) {
    return payload;
  }
  const std::uint64_t least = (usable_ - 12) * 32 / 255 - 23;
  const std::uint64_t local = least + (payload - least) % (usable_ - kLink);
  return local <= usable_ - 35 ? local : least;
}

std::optional<SqlitePages::Cell> SqlitePages::cell_at(Bytes page, std::uint64_t at) const {
  const auto payload = varint(page, at);
  const auto row = varint(page, at);
  if (!payload || !row || *payload > std::min(kLargestPiece, file_.size())) {
    return std::nullopt;
  }
  const std::uint64_t begin = at, local = local_size(*payload);
  Cell out;
  out.local_end = begin + local;
  const bool overflows = local < *payload;
  if (out.local_end + (overflows ? kLink : 0) > page.size()) {
    return std::nullopt;
  }
  if (overflows) {
    out.overflow = static_cast<std::uint32_t>(big_endian(page, out.local_end, kLink));
    if (out.overflow < 2 || out.overflow > pages_) {
      return std::nullopt;
    }
  }
  const auto head = varint(page, at);
  const auto id = varint(page, at), topic = varint(page, at), time = varint(page, at),
             data = varint(page, at);
  // The id is the row and stands nowhere else; the data are bytes.
  if (!data || *id != 0 || *data < 12 || *data % 2 != 0 || at - begin != *head) {
    return std::nullopt;
  }
  const auto topic_id = integer(page, *topic, at), t_ns = integer(page, *time, at);
  const std::uint64_t size = (*data - 12) / 2;
  if (!topic_id || !t_ns || at > out.local_end || at - begin + size != *payload) {
    return std::nullopt;
  }
  out.data = at;
  out.row = {static_cast<std::int64_t>(*row), *topic_id, *t_ns, 0, size};
  return out;
}

std::optional<MessageLeaf> SqlitePages::parse(std::uint32_t number) {
  const Bytes bytes = page(number);
  const std::uint64_t count = big_endian(bytes, 3, 2);
  if (bytes[0] != kTableLeaf || count == 0 || kLeafHead + 2 * count > bytes.size()) {
    return std::nullopt;
  }
  MessageLeaf out;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> extents;  // bytes in the page
  for (std::uint64_t k = 0; k < count; ++k) {
    const std::uint64_t at = big_endian(bytes, kLeafHead + 2 * k, 2);
    auto cell = at < kLeafHead + 2 * count ? std::nullopt : cell_at(bytes, at);
    if (!cell || cell->row.row <= (out.empty() ? -1 : out.back().row)) {
      return std::nullopt;
    }
    cell->row.cell = start_of(number) + at;
    out.push_back(cell->row);
    extents.emplace_back(at, cell->local_end + (cell->overflow != 0 ? kLink : 0));
  }
  std::sort(extents.begin(), extents.end());
  for (std::size_t k = 1; k < extents.size(); ++k) {
    if (extents[k].first < extents[k - 1].second) {
      return std::nullopt;
    }
  }
  return out;
}

std::vector<MessageLeaf> SqlitePages::leaves(const std::function<bool(std::int64_t)>& known) {
  const std::vector<bool> is_free = free_pages();
  std::vector<MessageLeaf> out;
  for (std::uint32_t number = 2; number <= pages_; ++number) {
    auto leaf = is_free[number] ? std::nullopt : parse(number);
    if (leaf &&
        std::all_of(leaf->begin(), leaf->end(), [&](const auto& row) { return known(row.topic_id); })) {
      out.push_back(*std::move(leaf));
    }
  }
  return without_twins(std::move(out));
}

void SqlitePages::read(std::uint64_t cell, std::uint64_t count, std::vector<std::uint8_t>& out,
                       std::uint64_t& size) {
  const auto number = static_cast<std::uint32_t>(cell / page_size_ + 1);
  Bytes bytes = page(number);
  const auto found = cell_at(bytes, cell - start_of(number));
  if (!found) {
    throw Damage("a row that is none");
  }
  size = found->row.size;
  count = std::min(count, size);
  const Bytes local = bytes.subspan(found->data, std::min(count, found->local_end - found->data));
  out.assign(local.begin(), local.end());
  for (std::uint32_t next = found->overflow; out.size() < count;) {
    bytes = page(next);  // throws where the chain leads out of the file, as it does beyond its end (0)
    next = static_cast<std::uint32_t>(big_endian(bytes, 0, kLink));
    const Bytes part = bytes.subspan(kLink, std::min<std::uint64_t>(count - out.size(), usable_ - kLink));
    out.insert(out.end(), part.begin(), part.end());
  }
}

}  // namespace limber::detail
