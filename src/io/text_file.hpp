// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace limber::detail {

/// The whole of a text file, without a byte order mark. @throws DataError if it is missing, not a file, not
/// readable, or holds bytes that no text has.
[[nodiscard]] std::string load_text(const std::filesystem::path& path);

/// Adds a note if the last line of the file has no line end, since a number in it may have lost its last
/// digits.
void note_if_cut_off(const std::filesystem::path& path, std::vector<std::string>& notes);

/// What the rows of a table must look like.
struct TableLayout {
  char separator = ',';                 ///< ',' or ' ' (any run of blanks)
  std::vector<std::string_view> names;  ///< of the columns, for messages
  std::vector<std::size_t> counts;      ///< allowed numbers of columns; the first row decides
};

/// @brief Walks through the rows of a text table. Skips blank lines and lines that start with '#'; line ends
/// may be \n or \r\n. Throws DataError, which names file and line, for all that does not fit: also for a line
/// of '#' above the rows that names the columns in another order.
class TableReader {
 public:
  static constexpr double kUnlimited = std::numeric_limits<double>::max();

  TableReader(std::filesystem::path path, TableLayout layout);

  [[nodiscard]] bool next();  ///< moves to the next row; false at the end of the file
  [[nodiscard]] std::size_t columns() const { return fields_.size(); }
  [[nodiscard]] std::string_view field(std::size_t column) const { return fields_[column]; }
  [[nodiscard]] std::size_t line() const { return line_; }

  [[nodiscard]] std::int64_t integer(std::size_t column) const;
  /// Finite, and not larger than `largest` in size: beyond it the column holds something else.
  [[nodiscard]] double number(std::size_t column, double largest = kUnlimited) const;
  [[nodiscard]] Eigen::Vector3d vector3(std::size_t first_column, double largest = kUnlimited) const;
  /// Rotation of a quaternion that this row holds. @throws DataError if its norm is far from 1
  [[nodiscard]] Eigen::Matrix3d rotation(const Eigen::Vector4d& wxyz) const;

  /// Column 0 as integer nanoseconds, later than in the row of the previous call.
  [[nodiscard]] std::int64_t increasing_time();
  /// The same for a time that came from elsewhere in the row.
  void require_later(std::int64_t t_ns);
  void require_a_row(std::string_view what) const;  ///< throws if the file had none

  [[noreturn]] void fail(const std::string& expected, const std::string& found) const;

 private:
  void split(std::string_view row);
  /// A line of names over the rows that knows one of ours at another place. @throws DataError
  void check_header(std::string_view header);
  void check_columns();
  [[nodiscard]] std::string name(std::size_t column) const;

  std::filesystem::path path_;
  TableLayout layout_;
  std::string text_;
  std::size_t begin_ = 0;
  std::size_t line_ = 0;
  std::size_t rows_ = 0;
  std::vector<std::string_view> fields_;
  std::int64_t last_t_ns_ = 0;
  bool has_last_t_ = false;
};

}  // namespace limber::detail
