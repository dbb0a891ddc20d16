// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace limber::detail {

/// The first line of a table: '#', then the names of its columns.
inline std::string header_of(const std::vector<std::string>& names) {
  return fmt::format("#{}", fmt::join(names, ","));
}

/// @brief Builds the text of a table, cell by cell. Numbers are printed as short as they can be read back
/// unchanged.
/// @throws std::invalid_argument, which names `what`, for a number that is not finite or a time that is not
/// later
///         than the one before
class TableText {
 public:
  TableText(std::string what, char separator) : what_(std::move(what)), separator_(separator) {}

  void header(std::string_view line) { fmt::format_to(std::back_inserter(text_), "{}\n", line); }

  void cell(std::string_view text) {
    if (!row_is_empty_) {
      text_.push_back(separator_);
    }
    text_.append(text);
    row_is_empty_ = false;
  }
  void cell(std::int64_t value) { cell(std::string_view(fmt::format_int(value).c_str())); }
  void cell(double value) {
    if (!std::isfinite(value)) {
      throw std::invalid_argument(what_ + ": a number is not finite");
    }
    fmt::memory_buffer digits;
    fmt::format_to(std::back_inserter(digits), "{}", value);
    cell(std::string_view(digits.data(), digits.size()));
  }
  template <typename Vector>
  void cells(const Vector& values) {
    for (const double value : values) {
      cell(value);
    }
  }
  void empty_cells(int count) {
    for (int k = 0; k < count; ++k) {
      cell(std::string_view{});
    }
  }
  void end_row() {
    text_.push_back('\n');
    row_is_empty_ = true;
  }

  /// A time [ns] as cell, later than the one of the previous call.
  void time(std::int64_t t_ns) {
    require_later(t_ns);
    cell(t_ns);
  }
  void require_later(std::int64_t t_ns) {
    if (has_last_t_ && t_ns <= last_t_ns_) {
      throw std::invalid_argument(
          fmt::format("{}: time {} ns does not come after {} ns", what_, t_ns, last_t_ns_));
    }
    last_t_ns_ = t_ns;
    has_last_t_ = true;
  }

  [[nodiscard]] std::string_view text() const { return {text_.data(), text_.size()}; }

 private:
  std::string what_;
  char separator_;
  fmt::memory_buffer text_;
  bool row_is_empty_ = true;
  bool has_last_t_ = false;
  std::int64_t last_t_ns_ = 0;
};

}  // namespace limber::detail
