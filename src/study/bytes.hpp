// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace limber::detail {

/// Values one after another as this machine holds them; text and lists with their length before them.
class ByteWriter {
 public:
  template <typename T>
  void put(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  template <typename T>
  void put(const std::optional<T>& value) {
    put(value.has_value());
    put(value.value_or(T{}));
  }
  void put(std::string_view text) {
    put(std::uint64_t{text.size()});
    bytes_.append(text);
  }
  void put(const std::string& text) { put(std::string_view(text)); }
  void put(const std::vector<double>& values) {
    put(std::uint64_t{values.size()});
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double));
  }

  [[nodiscard]] std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Reads what a ByteWriter wrote. @throws std::invalid_argument if the bytes end too early
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}

  template <typename T>
  void get(T& value) {
    static_assert(std::is_arithmetic_v<T>);
    std::memcpy(&value, next(sizeof value).data(), sizeof value);
  }
  template <typename T>
  void get(std::optional<T>& value) {
    const bool present = get<bool>();
    const T content = get<T>();
    value = present ? std::optional<T>(content) : std::nullopt;
  }
  void get(std::string& text) { text = next(get<std::uint64_t>()); }
  void get(std::vector<double>& values) {
    const std::string_view bytes = next(get<std::uint64_t>() * sizeof(double));
    values.resize(bytes.size() / sizeof(double));
    std::memcpy(values.data(), bytes.data(), bytes.size());
  }
  template <typename T>
  [[nodiscard]] T get() {
    T value{};
    get(value);
    return value;
  }

  void expect_end() const {
    if (!bytes_.empty()) {
      throw std::invalid_argument("bytes: more than expected");
    }
  }

 private:
  std::string_view next(std::uint64_t size) {
    if (size > bytes_.size()) {
      throw std::invalid_argument("bytes: fewer than expected");
    }
    const std::string_view part = bytes_.substr(0, size);
    bytes_.remove_prefix(size);
    return part;
  }

  std::string_view bytes_;
};

}  // namespace limber::detail
