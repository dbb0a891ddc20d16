// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace limber::detail {

using Bytes = std::span<const std::uint8_t>;

/// No chunk and no message of a bag is larger: what claims to be is damaged, or hostile.
inline constexpr std::uint64_t kLargestPiece = std::uint64_t{1} << 30;  // [bytes]

/// Part of a bag that cannot be read; what() says what was found.
class Damage : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Bytes that can be looked at anywhere.
class ByteSource {
 public:
  virtual ~ByteSource() = default;
  [[nodiscard]] virtual std::uint64_t size() const = 0;
  /// Bytes [at, at + count), valid until the next call. @throws Damage beyond the end
  [[nodiscard]] virtual Bytes view(std::uint64_t at, std::uint64_t count) = 0;
};

/// @brief The first byte at or behind `from` at which `pattern` stands whole before `end`; `end` if it stands
/// nowhere.
[[nodiscard]] std::uint64_t find_bytes(ByteSource& bytes, std::uint64_t from, std::uint64_t end,
                                       std::string_view pattern);

/// Bytes in memory.
class MemoryBytes final : public ByteSource {
 public:
  explicit MemoryBytes(Bytes bytes) : bytes_(bytes) {}
  [[nodiscard]] std::uint64_t size() const override { return bytes_.size(); }
  [[nodiscard]] Bytes view(std::uint64_t at, std::uint64_t count) override;

 private:
  Bytes bytes_;
};

/// A file, or a part of it, through a window of a few kilobytes.
class FileBytes final : public ByteSource {
 public:
  /// @throws DataError if the file cannot be opened
  explicit FileBytes(std::filesystem::path path);
  ~FileBytes() override;
  FileBytes(const FileBytes&) = delete;
  FileBytes& operator=(const FileBytes&) = delete;

  [[nodiscard]] std::uint64_t size() const override { return size_; }
  [[nodiscard]] Bytes view(std::uint64_t at, std::uint64_t count) override;
  /// The same, kept by the caller.
  [[nodiscard]] std::vector<std::uint8_t> copy(std::uint64_t at, std::uint64_t count) const;
  /// The same into memory that is used again.
  void copy(std::uint64_t at, std::uint64_t count, std::vector<std::uint8_t>& out) const;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  void read(std::uint64_t at, std::span<std::uint8_t> out) const;

  std::filesystem::path path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
  std::vector<std::uint8_t> window_;
  std::uint64_t window_at_ = 0;
};

/// Little-endian integers, one after another. @throws Damage beyond the end
class FieldReader {
 public:
  explicit FieldReader(Bytes bytes) : bytes_(bytes) {}
  [[nodiscard]] bool done() const { return at_ == bytes_.size(); }
  [[nodiscard]] std::size_t at() const { return at_; }
  [[nodiscard]] Bytes take(std::uint64_t count);
  template <typename Integer>
  [[nodiscard]] Integer integer() {
    Integer value = 0;
    const Bytes bytes = take(sizeof(Integer));
    for (std::size_t k = sizeof(Integer); k-- > 0;) {
      value = static_cast<Integer>(value << 7 << 1 | bytes[k]);
    }
    return value;
  }
  [[nodiscard]] std::string text();  ///< length (32 bits), then the bytes

 private:
  Bytes bytes_;
  std::size_t at_ = 0;
};

}  // namespace limber::detail
