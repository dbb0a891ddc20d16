// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>

#include "limber/bags/bag_file.hpp"

namespace limber::detail {

/// @brief Fields of a ROS message, one after another: ROS 1 (little-endian, packed) or CDR (aligned).
/// Beyond the end everything reads as zero and good() is false.
class MessageReader {
 public:
  MessageReader(std::span<const std::uint8_t> data, Serialization serialization)
      : data_(data), is_cdr_(serialization == Serialization::kCdr) {
    if (is_cdr_) {  // representation: 0 big-endian, 1 little-endian CDR; then two bytes of options
      const bool known = data.size() >= 4 && data[0] == 0 && data[1] <= 1;
      good_ = known;
      big_endian_ = known && data[1] == 0;
      at_ = 4;
    }
  }

  [[nodiscard]] bool good() const { return good_; }
  [[nodiscard]] std::size_t at() const { return at_; }
  [[nodiscard]] bool big_endian() const { return big_endian_; }

  template <typename Number>
  [[nodiscard]] Number number() {
    align(sizeof(Number));
    std::array<std::uint8_t, sizeof(Number)> bytes{};
    if (has(sizeof(Number))) {
      std::copy_n(data_.begin() + static_cast<std::ptrdiff_t>(at_), sizeof(Number), bytes.begin());
      at_ += sizeof(Number);
    }
    if (big_endian_ != (std::endian::native == std::endian::big)) {
      std::reverse(bytes.begin(), bytes.end());
    }
    return std::bit_cast<Number>(bytes);
  }

  [[nodiscard]] std::string text() {
    std::size_t size = number<std::uint32_t>();
    if (!has(size)) {
      return {};
    }
    std::string out(reinterpret_cast<const char*>(data_.data()) + at_, size);
    at_ += size;
    if (is_cdr_ && !out.empty() && out.back() == '\0') {
      out.pop_back();
    }
    return out;
  }

  [[nodiscard]] Eigen::Vector3d vector3() {
    const double x = number<double>(), y = number<double>(), z = number<double>();
    return {x, y, z};
  }

  void skip_doubles(std::size_t count) {
    align(sizeof(double));
    if (has(count * sizeof(double))) {
      at_ += count * sizeof(double);
    }
  }

  /// std_msgs/Header. @return its stamp [ns]
  [[nodiscard]] std::int64_t header() {
    if (!is_cdr_) {
      (void)number<std::uint32_t>();  // sequence number
    }
    const auto seconds =
        is_cdr_ ? std::int64_t{number<std::int32_t>()} : std::int64_t{number<std::uint32_t>()};
    const auto nanoseconds = number<std::uint32_t>();
    if (nanoseconds >= 1'000'000'000) {
      good_ = false;
    }
    return seconds * 1'000'000'000 + nanoseconds;
  }

 private:
  void align(std::size_t size) {
    if (is_cdr_) {
      at_ = 4 + (at_ - 4 + size - 1) / size * size;
    }
  }
  bool has(std::size_t count) {
    good_ = good_ && at_ <= data_.size() && count <= data_.size() - at_;
    return good_;
  }

  std::span<const std::uint8_t> data_;
  std::size_t at_ = 0;
  bool is_cdr_, good_ = true, big_endian_ = false;
};

}  // namespace limber::detail
