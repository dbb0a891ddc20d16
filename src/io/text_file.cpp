// SPDX-License-Identifier: MIT
#include "io/text_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>

#include "io/numbers.hpp"
#include "limber/core/errors.hpp"

namespace limber::detail {
namespace {

// [ns], so that the difference of two times always fits into 64 bits
constexpr std::int64_t kLargestTime = 4'000'000'000'000'000'000;
constexpr std::string_view kBlanks = " \t\r";

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) {
    return {};
  }
  return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

bool is_text(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return (byte >= 0x20 && byte != 0x7f) || c == '\n' || c == '\r' || c == '\t';
}

std::string counts_in_words(const std::vector<std::size_t>& counts) {
  if (counts.size() == 1) {
    return fmt::format("{}", counts.front());
  }
  return fmt::format("{} or {}", fmt::join(counts.begin(), counts.end() - 1, ", "), counts.back());
}

/// Of a column, without its unit and frames: w_x of "w_RS_S_x [rad s^-1]".
std::string plain_name(std::string_view name) {
  std::string out(trimmed(name.substr(0, name.find('['))));
  std::ranges::transform(out, out.begin(), [](unsigned char c) { return std::tolower(c); });
  for (const std::string_view frames : {"_rs_s", "_rs_r", "_rs"}) {
    if (const std::size_t at = out.find(frames); at != std::string::npos) {
      out.erase(at, frames.size());
      break;
    }
  }
  return out;
}

}  // namespace

std::string load_text(const std::filesystem::path& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) {
    throw DataError(path.string(), 0, "a text file", "no such file");
  }
  if (!std::filesystem::is_regular_file(status)) {
    throw DataError(path.string(), 0, "a text file", "something that is not a file");
  }
  std::ifstream stream(path, std::ios::binary);
  std::string text(std::filesystem::file_size(path, error), '\0');
  if (!stream.read(text.data(), static_cast<std::streamsize>(text.size()))) {
    throw DataError(path.string(), 0, "a readable text file", std::strerror(errno));
  }
  const auto bad = std::find_if_not(text.begin(), text.end(), is_text);
  if (bad != text.end()) {
    const auto line = static_cast<std::size_t>(std::count(text.begin(), bad, '\n')) + 1;
    throw DataError(path.string(), line, "text",
                    fmt::format("binary data (byte 0x{:02x})", static_cast<unsigned char>(*bad)));
  }
  if (text.starts_with("\xef\xbb\xbf")) {
    text.erase(0, 3);
  }
  return text;
}

void note_if_cut_off(const std::filesystem::path& path, std::vector<std::string>& notes) {
  std::ifstream stream(path, std::ios::binary | std::ios::ate);
  if (stream.tellg() > 0 && stream.seekg(-1, std::ios::end).peek() != '\n') {
    notes.push_back(path.string() + ": the last line has no line end, the file may have been cut off");
  }
}

TableReader::TableReader(std::filesystem::path path, TableLayout layout)
    : path_(std::move(path)), layout_(std::move(layout)), text_(load_text(path_)) {}

bool TableReader::next() {
  while (begin_ < text_.size()) {
    const std::size_t end = std::min(text_.find('\n', begin_), text_.size());
    const std::string_view row = trimmed(std::string_view(text_).substr(begin_, end - begin_));
    begin_ = end + 1;
    ++line_;
    if (!row.empty() && row.front() == '#' && rows_ == 0) {
      check_header(row.substr(1));
    }
    if (!row.empty() && row.front() != '#') {
      split(row);
      check_columns();
      ++rows_;
      return true;
    }
  }
  return false;
}

void TableReader::split(std::string_view row) {
  fields_.clear();
  const bool blanks = layout_.separator == ' ';
  while (true) {
    const std::size_t end = blanks ? row.find_first_of(kBlanks) : row.find(layout_.separator);
    if (end == std::string_view::npos) {
      fields_.push_back(trimmed(row));
      return;
    }
    fields_.push_back(trimmed(row.substr(0, end)));
    row.remove_prefix(end + 1);
    if (blanks) {
      row = trimmed(row);
    }
  }
}

void TableReader::check_header(std::string_view header) {
  split(trimmed(header));
  if (std::ranges::find(layout_.counts, fields_.size()) == layout_.counts.end()) {
    return;
  }
  std::vector<std::string> known;
  for (const std::string_view name : layout_.names) {
    known.push_back(plain_name(name));
  }
  for (std::size_t k = 0; k < fields_.size(); ++k) {
    const auto found = std::ranges::find(known, plain_name(fields_[k]));
    if (found != known.end() && found - known.begin() != static_cast<std::ptrdiff_t>(k)) {
      fail(fmt::format("the columns {}", fmt::join(layout_.names, ", ")),
           fmt::format("{} as column {}", fields_[k], k + 1));
    }
  }
}

void TableReader::check_columns() {
  if (std::find(layout_.counts.begin(), layout_.counts.end(), fields_.size()) == layout_.counts.end()) {
    const bool cut_off = begin_ > text_.size();
    fail(fmt::format("{} columns ({})", counts_in_words(layout_.counts), fmt::join(layout_.names, ", ")),
         fmt::format("{}{}", fields_.size(), cut_off ? ", and the file ends within this line" : ""));
  }
  layout_.counts.assign(1, fields_.size());
}

std::string TableReader::name(std::size_t column) const {
  return column < layout_.names.size() ? std::string(layout_.names[column])
                                       : fmt::format("column {}", column + 1);
}

std::int64_t TableReader::integer(std::size_t column) const {
  const auto value = parse_integer(fields_[column]);
  if (!value) {
    const bool is_time = name(column).ends_with("[ns]") && parse_number(fields_[column]) &&
                         fields_[column].find('.') != std::string_view::npos;
    fail("an integer for " + name(column) + (is_time ? " (nanoseconds; is this in seconds?)" : ""),
         excerpt(fields_[column]));
  }
  return *value;
}

double TableReader::number(std::size_t column, double largest) const {
  const auto value = parse_number(fields_[column]);
  if (!value || !std::isfinite(*value)) {
    fail("a finite number for " + name(column), excerpt(fields_[column]));
  }
  if (std::abs(*value) > largest) {
    fail(fmt::format("{} within ±{}", name(column), largest), excerpt(fields_[column]));
  }
  return *value;
}

Eigen::Vector3d TableReader::vector3(std::size_t first_column, double largest) const {
  return {number(first_column, largest), number(first_column + 1, largest),
          number(first_column + 2, largest)};
}

Eigen::Matrix3d TableReader::rotation(const Eigen::Vector4d& wxyz) const {
  const auto R = checked_quaternion(wxyz);
  if (!R) {
    fail("a unit quaternion", fmt::format("one of norm {:.6g}", wxyz.norm()));
  }
  return *R;
}

std::int64_t TableReader::increasing_time() {
  const std::int64_t t_ns = integer(0);
  require_later(t_ns);
  return t_ns;
}

void TableReader::require_later(std::int64_t t_ns) {
  if (t_ns > kLargestTime || t_ns < -kLargestTime) {
    fail("a timestamp between the years 1844 and 2096", fmt::format("{} ns", t_ns));
  }
  if (has_last_t_ && t_ns <= last_t_ns_) {
    fail(fmt::format("a timestamp later than the previous one ({} ns)", last_t_ns_),
         t_ns == last_t_ns_ ? "the same timestamp again" : fmt::format("{} ns", t_ns));
  }
  last_t_ns_ = t_ns;
  has_last_t_ = true;
}

void TableReader::require_a_row(std::string_view what) const {
  if (rows_ == 0) {
    throw DataError(path_.string(), 0, fmt::format("at least one {}", what), "none: the file has no data");
  }
}

void TableReader::fail(const std::string& expected, const std::string& found) const {
  throw DataError(path_.string(), line_, expected, found);
}

}  // namespace limber::detail
