// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "byte_source.hpp"

/// The pages of an SQLite file (https://sqlite.org/fileformat2.html), read without the tree that leads to
/// them.
namespace limber::detail {

/// A row of the table `messages`: id, topic_id, timestamp, data.
struct MessageRow {
  std::int64_t row = 0;       ///< its id
  std::int64_t topic_id = 0;  ///< of the table `topics`
  std::int64_t t_ns = 0;      ///< when it was recorded
  std::uint64_t cell = 0;     ///< byte in the file where it begins, never 0
  std::uint64_t size = 0;     ///< of the data [bytes]
};

/// The rows of one page, by rising id: at least one.
using MessageLeaf = std::vector<MessageRow>;

/// @brief A table `messages` that is read page by page.
class SqlitePages {
 public:
  /// @throws DataError if the file cannot be opened, Damage if its head is none
  explicit SqlitePages(const std::filesystem::path& path);

  /// @brief Pages all of whose bytes that matter are those of rows of `messages`, by rising rows. Left out
  /// are pages that SQLite has freed, and those whose rows stand on another page as well: one of the two is
  /// old.
  /// @param known  whether a topic_id is one of the bag
  /// @throws Damage if the list of free pages is broken: what was deleted could not be told from what was not
  [[nodiscard]] std::vector<MessageLeaf> leaves(const std::function<bool(std::int64_t)>& known);

  /// @brief The first `count` bytes of the data of the row whose cell begins at byte `cell`, or all of them.
  /// @param[out] size  of all of them
  /// @throws Damage if there is none, or the chain of its pages is broken
  void read(std::uint64_t cell, std::uint64_t count, std::vector<std::uint8_t>& out, std::uint64_t& size);

 private:
  struct Cell;
  [[nodiscard]] std::uint64_t start_of(std::uint32_t page) const { return (page - 1) * page_size_; }
  [[nodiscard]] Bytes page(std::uint32_t number);
  [[nodiscard]] std::vector<bool> free_pages();
  [[nodiscard]] std::optional<MessageLeaf> parse(std::uint32_t number);
  [[nodiscard]] std::optional<Cell> cell_at(Bytes page, std::uint64_t at) const;
  [[nodiscard]] std::uint64_t local_size(std::uint64_t payload) const;

  FileBytes file_;
  std::uint64_t page_size_ = 0, usable_ = 0;  // [bytes]
  std::uint32_t pages_ = 0;
};

}  // namespace limber::detail
