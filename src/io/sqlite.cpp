// SPDX-License-Identifier: MIT
#include "sqlite.hpp"

#include <sqlite3.h>

#include <cstring>
#include <utility>

#include "limber/core/errors.hpp"

namespace limber::detail {
namespace {

constexpr int kPatienceMs = 20'000;  // for another process that writes

std::string expectation(int code, const std::string& kind) {
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
    case SQLITE_ERROR:
      return kind;
    case SQLITE_BUSY:
      return "a database that no other program keeps locked";
    default:
      return "a database that does as it is told";
  }
}

int flags_of(SqliteFile::Mode mode) {
  switch (mode) {
    case SqliteFile::Mode::kReadOnly:
      return SQLite::OPEN_READONLY;
    case SqliteFile::Mode::kRead:  // needs to write, too, if it may: to roll back what a crash left half done
      return SQLite::OPEN_READWRITE;
    case SqliteFile::Mode::kCreate:
      break;
  }
  return SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE;
}

}  // namespace

SqliteFile::SqliteFile(std::filesystem::path path, Mode mode, std::string kind)
    : path_(std::move(path)), kind_(std::move(kind)), database_(open(mode)) {
  sqlite3* const handle = database_.getHandle();
  sqlite3_extended_result_codes(handle, 1);
  // A file from elsewhere may not run functions of its choice, nor change its own tables' description.
  sqlite3_db_config(handle, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  if (mode == Mode::kRead) {
    execute("PRAGMA query_only = ON");
  }
}

SQLite::Database SqliteFile::open(Mode mode) const {
  if (mode != Mode::kCreate && !std::filesystem::exists(path_)) {
    throw DataError(path_.string(), 0, kind_, "no such file");
  }
  try {
    return {path_.string(), flags_of(mode), kPatienceMs};
  } catch (const SQLite::Exception& error) {
    fail(error, 0);
  }
}

void SqliteFile::fail(const SQLite::Exception& error, int system_error) const {
  const int code = error.getErrorCode();
  std::string found = error.what();
  if ((code & 0xff) == SQLITE_IOERR && system_error != 0) {
    found += std::string(" (") + std::strerror(system_error) + ")";
  }
  throw DataError(path_.string(), 0, expectation(code, kind_), found);
}

void SqliteFile::fail(const SQLite::Exception& error) const {
  fail(error, sqlite3_system_errno(database_.getHandle()));
}

void SqliteFile::execute(const std::string& sql) {
  guarded([&] { return database_.exec(sql); });
}

std::int64_t SqliteFile::integer(const std::string& sql) const {
  SqliteStatement query = prepare(sql);
  return query.step() ? query.get<std::int64_t>() : 0;
}

SqliteStatement::SqliteStatement(const SqliteFile& file, const std::string& sql)
    : file_(file), statement_(file.guarded([&] { return SQLite::Statement(file.database(), sql); })) {}

SqliteStatement& SqliteStatement::put_number(double value) {
  file_.guarded([&] { statement_.bind(++put_, value); });
  return *this;
}

SqliteStatement& SqliteStatement::put_number(std::int64_t value) {
  file_.guarded([&] { statement_.bind(++put_, value); });
  return *this;
}

SqliteStatement& SqliteStatement::put(std::string_view text) {
  file_.guarded([&] { statement_.bind(++put_, std::string(text)); });
  return *this;
}

SqliteStatement& SqliteStatement::put_bytes(std::string_view bytes) {
  file_.guarded([&] { statement_.bind(++put_, bytes.data(), static_cast<int>(bytes.size())); });
  return *this;
}

SqliteStatement& SqliteStatement::put_null() {
  file_.guarded([&] { statement_.bind(++put_); });
  return *this;
}

SqliteStatement& SqliteStatement::put_column(const SQLite::Column& column) {
  switch (column.getType()) {
    case SQLITE_INTEGER:
      return put_number(column.getInt64());
    case SQLITE_FLOAT:
      return put_number(column.getDouble());
    case SQLITE_TEXT:
      return put(column.getString());
    case SQLITE_BLOB:
      return put_bytes(column.getString());
    default:
      return put_null();
  }
}

SqliteStatement& SqliteStatement::put_row(const SqliteStatement& row) {
  for (int k = 0; k < row.statement_.getColumnCount(); ++k) {
    put_column(row.statement_.getColumn(k));
  }
  return *this;
}

bool SqliteStatement::step() {
  got_ = 0;
  return file_.guarded([&] { return statement_.executeStep(); });
}

void SqliteStatement::reset() {
  (void)statement_.tryReset();  // repeats the error of the last step, which was reported then
  put_ = 0;
}

void SqliteStatement::run() {
  step();
  reset();
}

SQLite::Column SqliteStatement::next() {
  return file_.guarded([&] { return statement_.getColumn(got_++); });
}

std::string_view SqliteStatement::get_bytes() {
  const SQLite::Column column = next();
  const auto* const data = static_cast<const char*>(column.getBlob());
  const auto size = static_cast<std::size_t>(column.getBytes());
  return data == nullptr ? std::string_view() : std::string_view(data, size);
}

bool SqliteStatement::next_is_null() const {
  return file_.guarded([&] { return statement_.isColumnNull(got_); });
}

SqliteTransaction::SqliteTransaction(SqliteFile& file)
    : file_(file), transaction_(file.guarded([&] {
        return SQLite::Transaction(file.database(), SQLite::TransactionBehavior::IMMEDIATE);
      })) {}

void SqliteTransaction::commit() {
  file_.guarded([this] { transaction_.commit(); });
}

}  // namespace limber::detail
