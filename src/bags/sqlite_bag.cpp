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
  void require_table(const std::string& name) const;
  [[nodiscard]] std::map<std::int64_t, std::size_t> read_topics();
  /// The first `count` bytes of a message, or all of them; its size goes to `size`.
  void read_blob(std::int64_t row, std::uint64_t count, std::vector<std::uint8_t>& out, std::uint64_t& size);
  [[nodiscard]] std::optional<std::int64_t> time_of(std::optional<std::int64_t> row) const;
  void tell_gaps(const std::vector<RowGap>& gaps);

  SqliteFile file_;
  std::unique_ptr<sqlite3_blob, CloseBlob> blob_;  // goes before the database does
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

void SqliteBag::walk(const Wanted& wanted, const Visitor& visitor) {
  topics_.clear();
  damages_.clear();
  const auto indices = read_topics();
  std::vector<std::size_t> wanted_bytes;
  std::transform(topics_.begin(), topics_.end(), std::back_inserter(wanted_bytes), wanted);
  std::vector<std::uint8_t> data;
  std::size_t damaged = 0;
  const auto visit = [&](std::int64_t row, SqliteStatement& rows) {
    const auto topic = indices.find(rows.get<std::int64_t>());
    try {
      if (topic == indices.end()) {
        throw Damage(fmt::format("the message in row {} is of an unknown topic", row));
      }
      BagMessage message{topic->second, rows.get<std::int64_t>(), {}, {}};
      message.place.at = static_cast<std::uint64_t>(row);
      data.clear();
      if (wanted_bytes[topic->second] > 0) {
        read_blob(row, wanted_bytes[topic->second], data, message.place.size);
      }
      message.data = data;
      visitor(message);
    } catch (const Damage& damage) {
      if (damaged++ == 0) {
        damages_.push_back(fmt::format("{}: {}; it is left out", file_.path().string(), damage.what()));
      }
    }
  };
  const auto gaps = visit_rows(file_, "messages", "topic_id, timestamp", visit);
  tell_gaps(gaps);
  if (damaged > 1) {
    damages_.push_back(fmt::format("{}: {} more damaged messages", file_.path().string(), damaged - 1));
  }
}

std::optional<std::int64_t> SqliteBag::time_of(std::optional<std::int64_t> row) const {
  if (!row) {
    return std::nullopt;
  }
  SqliteStatement time = file_.prepare("SELECT timestamp FROM messages WHERE rowid = ?");
  return time.put(*row).step() ? std::optional(time.get<std::int64_t>()) : std::nullopt;
}

void SqliteBag::tell_gaps(const std::vector<RowGap>& gaps) {
  const std::string file = file_.path().string();
  for (std::size_t k = 0; k < std::min(gaps.size(), kMostDamages); ++k) {
    const RowGap& gap = gaps[k];
    const std::string rows =
        gap.after ? fmt::format("rows {} to {} are left out", gap.before.value_or(0) + 1, *gap.after - 1)
                  : fmt::format("what follows row {} is left out", gap.before.value_or(0));
    damages_.push_back(fmt::format("{}: a damaged page ({}); {}{}", file, gap.why, rows,
                                   when_lost(time_of(gap.before), time_of(gap.after))));
  }
  if (gaps.size() > kMostDamages) {
    damages_.push_back(fmt::format("{}: {} more damaged pages", file, gaps.size() - kMostDamages));
  }
}

std::vector<std::uint8_t> SqliteBag::read(const BagPlace& place) {
  std::vector<std::uint8_t> out;
  std::uint64_t size = 0;
  try {
    read_blob(static_cast<std::int64_t>(place.at), kLargestPiece, out, size);
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
