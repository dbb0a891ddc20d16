// SPDX-License-Identifier: MIT
#include "sqlite_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "limber/core/errors.hpp"

namespace limber::detail {
namespace {

constexpr std::int64_t kFirstRow = 0;
constexpr std::int64_t kLastRow = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t kOneByOne = 4096;  // rows behind a damaged page; a page shows fewer

/// Seeks the first row that can be read.
class RowSeeker {
 public:
  RowSeeker(const SqliteFile& file, const std::string& table)
      : seek_(file.prepare("SELECT rowid FROM " + table + " WHERE rowid >= ? ORDER BY rowid LIMIT 1")) {}

  /// Beyond `last`; nothing if there is none. Row by row first, so that no page between two damaged ones is
  /// missed, then in steps that double, and back to where the damage ends.
  [[nodiscard]] std::optional<std::int64_t> beyond(std::int64_t last) {
    std::int64_t step = 1, damaged = last;
    for (int k = 0; damaged < kLastRow; ++k) {
      step = k < kOneByOne ? 1 : step > kLastRow / 2 ? kLastRow : 2 * step;
      const std::int64_t row = damaged > kLastRow - step ? kLastRow : damaged + step;
      if (look(row)) {
        return back_to(damaged, row);
      }
      damaged = row;
    }
    return std::nullopt;
  }

 private:
  /// Whether the table can be read from `row` on: then `found_` is the row there, or nothing at its end.
  bool look(std::int64_t row) {
    try {
      seek_.reset();
      found_.reset();
      if (seek_.put(row).step()) {
        found_ = seek_.get<std::int64_t>();
      }
      return !found_ || *found_ >= row;
    } catch (const DataError&) {
      return false;
    }
  }

  /// The first readable row between one from which the table is damaged and one from which it is not.
  std::optional<std::int64_t> back_to(std::int64_t damaged, std::int64_t sound) {
    std::optional<std::int64_t> first = found_;
    while (sound - damaged > 1) {
      const std::int64_t middle = damaged + (sound - damaged) / 2;
      if (look(middle)) {
        sound = middle;
        first = found_;
      } else {
        damaged = middle;
      }
    }
    return first;
  }

  SqliteStatement seek_;
  std::optional<std::int64_t> found_;
};

/// Whether there is another row; `why` says what has ended them, if they have not ended by themselves.
bool step(const SqliteFile& file, SqliteStatement& rows, std::string& why) {
  try {
    return rows.step();
  } catch (const DataError&) {
    why = file.database().getErrorMsg();
    return false;
  }
}

}  // namespace

void visit_rows(const SqliteFile& file, const std::string& table, const std::string& columns,
                const std::function<void(std::int64_t, SqliteStatement&)>& visit,
                const std::function<void(const RowGap&)>& missing) {
  std::optional<std::int64_t> from = kFirstRow, last;
  while (from) {
    SqliteStatement rows =
        file.prepare(fmt::format("SELECT rowid, {} FROM {} WHERE rowid >= ? ORDER BY rowid", columns, table));
    rows.put(*from);
    std::string why;
    while (step(file, rows, why)) {
      last = rows.get<std::int64_t>();
      visit(*last, rows);
    }
    if (why.empty()) {
      break;
    }
    from = RowSeeker(file, table).beyond(std::max(last.value_or(kFirstRow), *from));
    missing({last, from, why});
  }
}

}  // namespace limber::detail
