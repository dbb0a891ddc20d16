// SPDX-License-Identifier: MIT
#include "sqlite.hpp"

#include <cstring>
#include <utility>

#include "limber/core/errors.hpp"

namespace limber::detail {
namespace {

constexpr int kPatienceMs = 20'000;  // for another process that writes

std::string expectation(int code) {
  switch (code & 0xff) {
    case SQLITE_FULL:
      return "room on the disk";
    case SQLITE_IOERR:
      return "a disk that can be read and written";
    case SQLITE_READONLY:
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
      return "a database that can be made and written here";
    case SQLITE_NOTADB:
    case SQLITE_CORRUPT:
      return "a study, an SQLite database";
    case SQLITE_BUSY:
      return "a database that no other program keeps locked";
    default:
      return "a database that does as it is told";
  }
}

}  // namespace

SqliteFile::SqliteFile(std::filesystem::path path, Mode mode) : path_(std::move(path)) {
  if (mode == Mode::kRead && !std::filesystem::exists(path_)) {
    throw DataError(path_.string(), 0, "a study, an SQLite database", "no such file");
  }
  sqlite3* handle = nullptr;
  // A reader needs to write, too, if it may: to roll back what a crash left half done.
  const int flags = SQLITE_OPEN_READWRITE | (mode == Mode::kCreate ? SQLITE_OPEN_CREATE : 0);
  const int code = sqlite3_open_v2(path_.c_str(), &handle, flags, nullptr);
  handle_.reset(handle);
  if (code != SQLITE_OK) {
    fail(code);
  }
  sqlite3_extended_result_codes(handle, 1);
  sqlite3_busy_timeout(handle, kPatienceMs);
  // A file from elsewhere may not run functions of its choice, nor change its own tables' description.
  sqlite3_db_config(handle, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  if (mode == Mode::kRead) {
    execute("PRAGMA query_only = ON");
  }
}

void SqliteFile::fail(int code) const {
  std::string found = handle_ ? sqlite3_errmsg(handle_.get()) : sqlite3_errstr(code);
  const int system_error = handle_ ? sqlite3_system_errno(handle_.get()) : 0;
  if ((code & 0xff) == SQLITE_IOERR && system_error != 0) {
    found += std::string(" (") + std::strerror(system_error) + ")";
  }
  throw DataError(path_.string(), 0, expectation(code), found);
}

void SqliteFile::execute(const std::string& sql) {
  const int code = sqlite3_exec(handle_.get(), sql.c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) {
    fail(code);
  }
}

std::int64_t SqliteFile::integer(const std::string& sql) const {
  SqliteStatement query = prepare(sql);
  return query.step() ? query.get<std::int64_t>() : 0;
}

SqliteStatement::SqliteStatement(const SqliteFile& file, const std::string& sql) : file_(file) {
  sqlite3_stmt* statement = nullptr;
  check(sqlite3_prepare_v2(file.handle(), sql.c_str(), static_cast<int>(sql.size()), &statement, nullptr));
  statement_.reset(statement);
}

void SqliteStatement::check(int code) const {
  if (code != SQLITE_OK) {
    file_.fail(code);
  }
}

SqliteStatement& SqliteStatement::put(std::string_view text) {
  check(
      sqlite3_bind_text64(statement_.get(), ++put_, text.data(), text.size(), SQLITE_TRANSIENT, SQLITE_UTF8));
  return *this;
}

SqliteStatement& SqliteStatement::put_bytes(std::string_view bytes) {
  check(sqlite3_bind_blob64(statement_.get(), ++put_, bytes.data(), bytes.size(), SQLITE_TRANSIENT));
  return *this;
}

SqliteStatement& SqliteStatement::put_null() {
  check(sqlite3_bind_null(statement_.get(), ++put_));
  return *this;
}

SqliteStatement& SqliteStatement::put_row(const SqliteStatement& row) {
  for (int k = 0; k < sqlite3_column_count(row.statement_.get()); ++k) {
    check(sqlite3_bind_value(statement_.get(), ++put_, sqlite3_column_value(row.statement_.get(), k)));
  }
  return *this;
}

bool SqliteStatement::step() {
  got_ = 0;
  const int code = sqlite3_step(statement_.get());
  if (code != SQLITE_ROW && code != SQLITE_DONE) {
    file_.fail(code);
  }
  return code == SQLITE_ROW;
}

void SqliteStatement::reset() {
  sqlite3_reset(statement_.get());  // repeats the error of the last step, which was reported then
  put_ = 0;
}

void SqliteStatement::run() {
  step();
  reset();
}

std::string_view SqliteStatement::get_bytes() {
  const auto* const data = static_cast<const char*>(sqlite3_column_blob(statement_.get(), got_));
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), got_++));
  return data == nullptr ? std::string_view() : std::string_view(data, size);
}

bool SqliteStatement::next_is_null() const {
  return sqlite3_column_type(statement_.get(), got_) == SQLITE_NULL;
}

SqliteTransaction::SqliteTransaction(SqliteFile& file) : file_(file) { file_.execute("BEGIN IMMEDIATE"); }

SqliteTransaction::~SqliteTransaction() {
  if (open_) {
    // Where SQLite has rolled back by itself (full disk), there is nothing left to undo, and this fails.
    sqlite3_exec(file_.handle(), "ROLLBACK", nullptr, nullptr, nullptr);
  }
}

void SqliteTransaction::commit() {
  file_.execute("COMMIT");
  open_ = false;
}

}  // namespace limber::detail
