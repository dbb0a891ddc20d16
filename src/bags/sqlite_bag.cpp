// SPDX-License-Identifier: MIT
// ROS 2 bags in SQLite: tables `topics` and `messages`, as rosbag2_storage_sqlite3 writes them.
#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <map>
#include <string>

#include "byte_source.hpp"
#include "io/sqlite.hpp"
#include "limber/core/errors.hpp"
#include "loss.hpp"
#include "openers.hpp"
#include "sqlite_pages.hpp"
#include "sqlite_rows.hpp"

namespace limber::detail {
namespace {

constexpr const char* kRos2Bag = "a ROS 2 bag (tables topics and messages)";

struct CloseBlob {
  void operator()(sqlite3_blob* blob) const { sqlite3_blob_close(blob); }
};

class SqliteBag final : public BagFile {
 public:
  explicit SqliteBag(std::filesystem::path path);
  void walk(const Wanted& wanted, const Visitor& visitor) override;
  [[nodiscard]] std::vector<std::uint8_t> read(const BagPlace& place) override;
  [[nodiscard]] const std::vector<BagTopic>& topics() const override { return topics_; }
  [[nodiscard]] const std::vector<std::string>& damages() const override { return damages_; }
  [[nodiscard]] bool is_whole() const override { return damages_.empty(); }
  [[nodiscard]] std::string format() const override { return "ROS 2 bag (sqlite3)"; }

 private:
  /// What one walk is about, and what it has met.
  struct Walk {
    const Visitor& visitor;
    std::map<std::int64_t, std::size_t> indices;  ///< of topics, by id
    std::vector<std::size_t> wanted;              ///< bytes of the messages of each topic
    std::size_t damaged = 0, gaps = 0;
  };
  void require_table(const std::string& name) const;
  [[nodiscard]] std::map<std::int64_t, std::size_t> read_topics();
  void hand_out(Walk& walk, const MessageRow& row);
  /// The first `count` bytes of a message, or all of them; its size goes to `size`.
  void read_data(const BagPlace& place, std::uint64_t count, std::vector<std::uint8_t>& out,
                 std::uint64_t& size);
  void read_blob(std::int64_t row, std::uint64_t count, std::vector<std::uint8_t>& out, std::uint64_t& size);
  [[nodiscard]] std::optional<std::int64_t> time_of(std::optional<std::int64_t> row) const;
  [[nodiscard]] SqlitePages& pages();
  [[nodiscard]] std::vector<MessageLeaf> all_leaves(const Walk& walk);
  [[nodiscard]] std::string fill_gap(Walk& walk, const RowGap& gap);
  void take_gap(Walk& walk, const RowGap& gap);

  SqliteFile file_;
  std::unique_ptr<sqlite3_blob, CloseBlob> blob_;  // goes before the database does
  std::unique_ptr<SqlitePages> pages_;             // once they are needed
  std::optional<std::vector<MessageLeaf>> leaves_;
  std::vector<BagTopic> topics_;
  std::vector<std::string> damages_;
};

SqliteBag::SqliteBag(std::filesystem::path path)
    : file_(std::move(path), SqliteFile::Mode::kReadOnly, kRos2Bag) {
  sqlite3_limit(file_.database().getHandle(), SQLITE_LIMIT_LENGTH, static_cast<int>(kLargestPiece));
  require_table("topics");
  require_table("messages");
}

// A real table: a view could make its rows up without end.
void SqliteBag::require_table(const std::string& name) const {
  if (file_.integer("SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name = '" + name + "'") ==
      0) {
    throw DataError(file_.path().string(), 0, kRos2Bag, "an SQLite database without a table " + name);
  }
}

std::map<std::int64_t, std::size_t> SqliteBag::read_topics() {
  SqliteStatement rows = file_.prepare("SELECT id, name, type, serialization_format FROM topics ORDER BY id");
  std::map<std::int64_t, std::size_t> indices;
  while (rows.step()) {
    indices[rows.get<std::int64_t>()] = topics_.size();
    std::string name, type, serialization;
    rows.get(name);
    rows.get(type);
    rows.get(serialization);
    topics_.push_back({name, without_msg(type), serialization_from(serialization), serialization});
  }
  return indices;
}

void SqliteBag::read_blob(std::int64_t row, std::uint64_t count, std::vector<std::uint8_t>& out,
                          std::uint64_t& size) {
  int code = SQLITE_OK;
  if (blob_) {
    code = sqlite3_blob_reopen(blob_.get(), row);
  } else {
    sqlite3_blob* blob = nullptr;
    code = sqlite3_blob_open(file_.database().getHandle(), "main", "messages", "data", row, 0, &blob);
    blob_.reset(blob);
  }
  if (code == SQLITE_OK) {
    size = static_cast<std::uint64_t>(sqlite3_blob_bytes(blob_.get()));
    out.resize(std::min(count, size));
    code = sqlite3_blob_read(blob_.get(), out.data(), static_cast<int>(out.size()), 0);
  }
  if (code != SQLITE_OK) {
    blob_.reset();
    throw Damage(fmt::format("the message in row {} is damaged ({})", row, sqlite3_errstr(code)));
  }
}

void SqliteBag::read_data(const BagPlace& place, std::uint64_t count, std::vector<std::uint8_t>& out,
                          std::uint64_t& size) {
  if (place.within != 0) {
    pages().read(place.within, count, out, size);
  } else {
    read_blob(static_cast<std::int64_t>(place.at), count, out, size);
  }
}

void SqliteBag::hand_out(Walk& walk, const MessageRow& row) {
  try {
    const auto topic = walk.indices.find(row.topic_id);
    if (topic == walk.indices.end()) {
      throw Damage(fmt::format("the message in row {} is of an unknown topic", row.row));
    }
    BagMessage message{topic->second, row.t_ns, {}, {}};
    message.place.at = static_cast<std::uint64_t>(row.row);
    message.place.within = row.cell;
    std::vector<std::uint8_t> data;
    if (const std::size_t wanted = walk.wanted[topic->second]; wanted > 0) {
      read_data(message.place, wanted, data, message.place.size);
    }
    message.data = data;
    walk.visitor(message);
  } catch (const Damage& damage) {
    if (walk.damaged++ == 0) {
      damages_.push_back(fmt::format("{}: {}; it is left out", file_.path().string(), damage.what()));
    }
  }
}

void SqliteBag::walk(const Wanted& wanted, const Visitor& visitor) {
  topics_.clear();
  damages_.clear();
  leaves_.reset();
  Walk walk{visitor, read_topics(), {}};
  std::transform(topics_.begin(), topics_.end(), std::back_inserter(walk.wanted), wanted);
  visit_rows(
      file_, "messages", "topic_id, timestamp",
      [&](std::int64_t row, SqliteStatement& columns) {
        const auto topic_id = columns.get<std::int64_t>();
        hand_out(walk, {row, topic_id, columns.get<std::int64_t>()});
      },
      [&](const RowGap& gap) { take_gap(walk, gap); });
  const auto more = [&](std::size_t count, std::size_t told, const char* what) {
    if (count > told) {
      damages_.push_back(fmt::format("{}: {} more damaged {}", file_.path().string(), count - told, what));
    }
  };
  more(walk.gaps, kMostDamages, "pages");
  more(walk.damaged, 1, "messages");
}

std::optional<std::int64_t> SqliteBag::time_of(std::optional<std::int64_t> row) const {
  if (!row) {
    return std::nullopt;
  }
  SqliteStatement time = file_.prepare("SELECT timestamp FROM messages WHERE rowid = ?");
  return time.put(*row).step() ? std::optional(time.get<std::int64_t>()) : std::nullopt;
}

SqlitePages& SqliteBag::pages() {
  if (!pages_) {
    pages_ = std::make_unique<SqlitePages>(file_.path());
  }
  return *pages_;
}

/// All sound pages of messages; none where they cannot be told from old ones.
std::vector<MessageLeaf> SqliteBag::all_leaves(const Walk& walk) {
  SqliteStatement columns = file_.prepare("SELECT group_concat(name) FROM pragma_table_info('messages')");
  std::error_code none;
  const auto newer = std::filesystem::file_size(file_.path().string() + "-wal", none);
  if (!columns.step() || columns.get_bytes() != "id,topic_id,timestamp,data" || (!none && newer > 0)) {
    return {};
  }
  try {
    return pages().leaves([&](std::int64_t topic) { return walk.indices.count(topic) != 0; });
  } catch (const Damage&) {
    return {};
  }
}

/// Rows from `first` on that end before `end`, or do not; and when.
std::string rows_lost(std::int64_t first, std::optional<std::int64_t> end, const std::string& when) {
  return (end ? fmt::format("rows {} to {} are left out", first, *end - 1)
              : fmt::format("what follows row {} is left out", first - 1)) +
         when;
}

/// Hands out the rows of a gap whose own pages are sound. @return what has become of its rows, in words
std::string SqliteBag::fill_gap(Walk& walk, const RowGap& gap) {
  if (!leaves_) {
    leaves_ = all_leaves(walk);
  }
  std::int64_t next = gap.before.value_or(0) + 1;
  std::size_t found = 0;
  std::optional<std::int64_t> before_ns = time_of(gap.before);
  std::string read, lost;
  for (const MessageLeaf& leaf : *leaves_) {
    const MessageRow &first = leaf.front(), &last = leaf.back();
    if (first.row <= gap.before.value_or(-1) || (gap.after && last.row >= *gap.after)) {
      continue;
    }
    if (first.row > next) {
      lost += "; " + rows_lost(next, first.row, when_lost(before_ns, first.t_ns));
    }
    for (const MessageRow& row : leaf) {
      hand_out(walk, row);
    }
    found += leaf.size();
    next = last.row + 1;
    before_ns = last.t_ns;
    read = fmt::format("; {} rows up to {} are read from their own pages, to which it led", found, last.row);
  }
  if (gap.after ? next < *gap.after : found == 0) {
    lost += "; " + rows_lost(next, gap.after, when_lost(before_ns, time_of(gap.after)));
  }
  return read + lost;
}

void SqliteBag::take_gap(Walk& walk, const RowGap& gap) {
  const std::string became = fill_gap(walk, gap);
  if (walk.gaps++ < kMostDamages) {
    damages_.push_back(fmt::format("{}: a damaged page ({}){}", file_.path().string(), gap.why, became));
  }
}

std::vector<std::uint8_t> SqliteBag::read(const BagPlace& place) {
  std::vector<std::uint8_t> out;
  std::uint64_t size = 0;
  try {
    read_data(place, kLargestPiece, out, size);
  } catch (const Damage& damage) {
    throw DataError(file_.path().string(), 0, "a message", damage.what());
  }
  return out;
}

}  // namespace

std::unique_ptr<BagFile> open_sqlite_bag(const std::filesystem::path& path) {
  return std::make_unique<SqliteBag>(path);
}

}  // namespace limber::detail
