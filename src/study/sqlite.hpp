// SPDX-License-Identifier: MIT
#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

/// SQLite as this room uses it. Everything throws DataError: the file, what was expected of it, what SQLite
/// says.
namespace limber::detail {

class SqliteFile;

/// @brief A prepared statement. Parameters are put and columns got one after another, in their order in the
/// SQL.
class SqliteStatement {
 public:
  SqliteStatement(const SqliteFile& file, const std::string& sql);

  template <typename T>
  SqliteStatement& put(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    if constexpr (std::is_floating_point_v<T>) {
      check(sqlite3_bind_double(statement_.get(), ++put_, value));
    } else {
      check(sqlite3_bind_int64(statement_.get(), ++put_, static_cast<sqlite3_int64>(value)));
    }
    return *this;
  }
  template <typename T>
  SqliteStatement& put(const std::optional<T>& value) {
    return value ? put(*value) : put_null();
  }
  SqliteStatement& put(std::string_view text);
  SqliteStatement& put(const std::string& text) { return put(std::string_view(text)); }
  SqliteStatement& put_bytes(std::string_view bytes);
  SqliteStatement& put_null();
  /// All columns of another statement's row.
  SqliteStatement& put_row(const SqliteStatement& row);

  /// @return whether there is a row, whose columns can then be got
  bool step();
  /// Runs a statement that has no rows, and makes it ready for the next parameters.
  void run();
  void reset();

  template <typename T>
  void get(T& value) {
    static_assert(std::is_arithmetic_v<T>);
    if constexpr (std::is_floating_point_v<T>) {
      value = sqlite3_column_double(statement_.get(), got_++);
    } else {
      value = static_cast<T>(sqlite3_column_int64(statement_.get(), got_++));
    }
  }
  template <typename T>
  void get(std::optional<T>& value) {
    value = next_is_null() ? (++got_, std::nullopt) : std::optional<T>(get<T>());
  }
  template <typename T>
  [[nodiscard]] T get() {
    T value{};
    get(value);
    return value;
  }
  void get(std::string& value) { value = get_bytes(); }
  /// Text or bytes; valid until the next step.
  [[nodiscard]] std::string_view get_bytes();
  [[nodiscard]] bool next_is_null() const;

 private:
  void check(int code) const;

  struct Finalize {
    void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
  };
  const SqliteFile& file_;
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
  int put_ = 0, got_ = 0;
};

/// @brief An open database file. With a rollback journal: one file when nobody writes, and a reader or writer
/// that comes after a crash finds the last whole transaction.
class SqliteFile {
 public:
  enum class Mode { kRead, kCreate };
  SqliteFile(std::filesystem::path path, Mode mode);

  void execute(const std::string& sql);
  [[nodiscard]] SqliteStatement prepare(const std::string& sql) const { return {*this, sql}; }
  /// The one number that a query gives.
  [[nodiscard]] std::int64_t integer(const std::string& sql) const;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] sqlite3* handle() const { return handle_.get(); }
  [[noreturn]] void fail(int code) const;

 private:
  struct Close {
    void operator()(sqlite3* handle) const { sqlite3_close_v2(handle); }
  };
  std::filesystem::path path_;
  std::unique_ptr<sqlite3, Close> handle_;
};

/// All or nothing: what is not committed is undone. Nobody else writes meanwhile.
class SqliteTransaction {
 public:
  explicit SqliteTransaction(SqliteFile& file);
  ~SqliteTransaction();
  SqliteTransaction(const SqliteTransaction&) = delete;
  SqliteTransaction& operator=(const SqliteTransaction&) = delete;

  void commit();

 private:
  SqliteFile& file_;
  bool open_ = true;
};

}  // namespace limber::detail
