// SPDX-License-Identifier: MIT
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

/// SQLite by SQLiteCpp, as studies and bags use it. Everything throws DataError: the file, what was expected
/// of it, what SQLite says.
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
      return put_number(static_cast<double>(value));
    } else {
      return put_number(static_cast<std::int64_t>(value));
    }
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
      value = next().getDouble();
    } else {
      value = static_cast<T>(next().getInt64());
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
  SqliteStatement& put_number(double value);
  SqliteStatement& put_number(std::int64_t value);
  SqliteStatement& put_column(const SQLite::Column& column);
  [[nodiscard]] SQLite::Column next();

  const SqliteFile& file_;
  SQLite::Statement statement_;
  int put_ = 0, got_ = 0;
};

/// @brief An open database file. With a rollback journal: one file when nobody writes, and a reader or writer
/// that comes after a crash finds the last whole transaction.
class SqliteFile {
 public:
  enum class Mode {
    kReadOnly,  ///< nothing is written, not even what a crash left half done is rolled back
    kRead,
    kCreate
  };
  /// @param kind  what the file is expected to be, in words
  SqliteFile(std::filesystem::path path, Mode mode, std::string kind);

  void execute(const std::string& sql);
  [[nodiscard]] SqliteStatement prepare(const std::string& sql) const { return {*this, sql}; }
  /// The one number that a query gives.
  [[nodiscard]] std::int64_t integer(const std::string& sql) const;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] SQLite::Database& database() { return database_; }
  [[nodiscard]] const SQLite::Database& database() const { return database_; }

  /// What `act` returns. @throws DataError for what SQLite says meanwhile
  template <typename Act>
  auto guarded(const Act& act) const {
    try {
      return act();
    } catch (const SQLite::Exception& error) {
      fail(error);
    }
  }

 private:
  [[nodiscard]] SQLite::Database open(Mode mode) const;
  [[noreturn]] void fail(const SQLite::Exception& error, int system_error) const;
  [[noreturn]] void fail(const SQLite::Exception& error) const;

  std::filesystem::path path_;
  std::string kind_;
  SQLite::Database database_;
};

/// All or nothing: what is not committed is undone. Nobody else writes meanwhile.
class SqliteTransaction {
 public:
  explicit SqliteTransaction(SqliteFile& file);
  void commit();

 private:
  SqliteFile& file_;
  SQLite::Transaction transaction_;
};

}  // namespace limber::detail
