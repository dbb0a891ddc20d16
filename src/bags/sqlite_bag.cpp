// SPDX-License-Identifier: MIT
// ROS 2 bags in SQLite: tables `topics` and `messages`, as rosbag2_storage_sqlite3 writes them.
#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <map>
#include <string>

#include "byte_source.hpp"
#include "limber/core/errors.hpp"
#include "openers.hpp"

namespace limber::detail {
namespace {

struct Close {
  void operator()(sqlite3* database) const { sqlite3_close(database); }
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
  void operator()(sqlite3_blob* blob) const { sqlite3_blob_close(blob); }
};
using Database = std::unique_ptr<sqlite3, Close>;
using Statement = std::unique_ptr<sqlite3_stmt, Close>;

class SqliteBag final : public BagFile {
 public:
  explicit SqliteBag(std::filesystem::path path);
  void walk(const Wanted& wanted, const Visitor& visitor) override;
  [[nodiscard]] std::vector<std::uint8_t> read(const BagPlace& place) override;
  [[nodiscard]] const std::vector<BagTopic>& topics() const override { return topics_; }
  [[nodiscard]] const std::vector<std::string>& damages() const override { return damages_; }
  [[nodiscard]] std::string format() const override { return "ROS 2 bag (sqlite3)"; }

 private:
  [[noreturn]] void fail(const std::string& expected) const;
  [[nodiscard]] Statement prepare(const std::string& sql) const;
  void require_table(const std::string& name) const;
  [[nodiscard]] std::map<std::int64_t, std::size_t> read_topics();
  /// The first `count` bytes of a message, or all of them; its size goes to `size`.
  void read_blob(std::int64_t row, std::uint64_t count, std::vector<std::uint8_t>& out, std::uint64_t& size);

  std::filesystem::path path_;
  Database database_;
  std::unique_ptr<sqlite3_blob, Close> blob_;  // goes before the database does
  std::vector<BagTopic> topics_;
  std::vector<std::string> damages_;
};

SqliteBag::SqliteBag(std::filesystem::path path) : path_(std::move(path)) {
  sqlite3* database = nullptr;
  const int code = sqlite3_open_v2(path_.c_str(), &database, SQLITE_OPEN_READONLY, nullptr);
  database_.reset(database);
  if (code != SQLITE_OK) {
    fail("a readable ROS 2 bag");
  }
  // What a stranger's file may make SQLite do.
  sqlite3_db_config(database, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(database, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_limit(database, SQLITE_LIMIT_LENGTH, static_cast<int>(kLargestPiece));
  require_table("topics");
  require_table("messages");
}

void SqliteBag::fail(const std::string& expected) const {
  throw DataError(path_.string(), 0, expected,
                  fmt::format("what SQLite calls '{}'", sqlite3_errmsg(database_.get())));
}

Statement SqliteBag::prepare(const std::string& sql) const {
  sqlite3_stmt* statement = nullptr;
  if (sqlite3_prepare_v2(database_.get(), sql.c_str(), -1, &statement, nullptr) != SQLITE_OK) {
    fail("a ROS 2 bag (tables topics and messages)");
  }
  return Statement(statement);
}

// A real table: a view could make its rows up without end.
void SqliteBag::require_table(const std::string& name) const {
  const Statement statement =
      prepare("SELECT 1 FROM sqlite_master WHERE type = 'table' AND name = '" + name + "'");
  const int code = sqlite3_step(statement.get());
  if (code != SQLITE_ROW && code != SQLITE_DONE) {
    fail("a ROS 2 bag (tables topics and messages)");
  }
  if (code == SQLITE_DONE) {
    throw DataError(path_.string(), 0, "a ROS 2 bag (tables topics and messages)",
                    "an SQLite database without a table " + name);
  }
}

std::map<std::int64_t, std::size_t> SqliteBag::read_topics() {
  const Statement statement = prepare("SELECT id, name, type, serialization_format FROM topics ORDER BY id");
  const auto text = [&](int column) {
    const unsigned char* value = sqlite3_column_text(statement.get(), column);
    return value == nullptr ? std::string() : std::string(reinterpret_cast<const char*>(value));
  };
  std::map<std::int64_t, std::size_t> indices;
  int code = SQLITE_ROW;
  while ((code = sqlite3_step(statement.get())) == SQLITE_ROW) {
    indices[sqlite3_column_int64(statement.get(), 0)] = topics_.size();
    topics_.push_back({text(1), without_msg(text(2)), serialization_from(text(3)), text(3)});
  }
  if (code != SQLITE_DONE) {
    fail("the topics of a ROS 2 bag");
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
    code = sqlite3_blob_open(database_.get(), "main", "messages", "data", row, 0, &blob);
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
  const Statement statement = prepare("SELECT rowid, topic_id, timestamp FROM messages ORDER BY rowid");
  std::vector<std::uint8_t> data;
  std::size_t damaged = 0;
  int code = SQLITE_ROW;
  while ((code = sqlite3_step(statement.get())) == SQLITE_ROW) {
    const std::int64_t row = sqlite3_column_int64(statement.get(), 0);
    const auto topic = indices.find(sqlite3_column_int64(statement.get(), 1));
    try {
      if (topic == indices.end()) {
        throw Damage(fmt::format("the message in row {} is of an unknown topic", row));
      }
      BagMessage message{topic->second, sqlite3_column_int64(statement.get(), 2), {}, {}};
      message.place.at = static_cast<std::uint64_t>(row);
      data.clear();
      if (wanted_bytes[topic->second] > 0) {
        read_blob(row, wanted_bytes[topic->second], data, message.place.size);
      }
      message.data = data;
      visitor(message);
    } catch (const Damage& damage) {
      if (damaged++ == 0) {
        damages_.push_back(fmt::format("{}: {}; it is left out", path_.string(), damage.what()));
      }
    }
  }
  if (damaged > 1) {
    damages_.push_back(fmt::format("{}: {} more damaged messages", path_.string(), damaged - 1));
  }
  if (code != SQLITE_DONE) {
    damages_.push_back(fmt::format("{}: the database is damaged ({}); what follows is left out",
                                   path_.string(), sqlite3_errmsg(database_.get())));
  }
}

std::vector<std::uint8_t> SqliteBag::read(const BagPlace& place) {
  std::vector<std::uint8_t> out;
  std::uint64_t size = 0;
  try {
    read_blob(static_cast<std::int64_t>(place.at), kLargestPiece, out, size);
  } catch (const Damage& damage) {
    throw DataError(path_.string(), 0, "a message", damage.what());
  }
  return out;
}

}  // namespace

std::unique_ptr<BagFile> open_sqlite_bag(const std::filesystem::path& path) {
  return std::make_unique<SqliteBag>(path);
}

}  // namespace limber::detail
