// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <bit>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace limber::detail {

/// Fields of a message in little-endian CDR, one after another.
class CdrWriter {
 public:
  CdrWriter() : bytes_{0, 1, 0, 0} {}

  template <typename Number>
  void number(Number value) {
    static_assert(std::endian::native == std::endian::little);
    while ((bytes_.size() - 4) % sizeof(Number) != 0) {
      bytes_.push_back(0);
    }
    const auto* begin = reinterpret_cast<const std::uint8_t*>(&value);
    bytes_.insert(bytes_.end(), begin, begin + sizeof(Number));
  }
  void text(std::string_view text) {
    number(static_cast<std::uint32_t>(text.size() + 1));
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    bytes_.push_back(0);
  }
  void data(std::span<const std::uint8_t> data) {
    number(static_cast<std::uint32_t>(data.size()));
    bytes_.insert(bytes_.end(), data.begin(), data.end());
  }
  void vector3(const Eigen::Vector3d& v) {
    for (const double value : v) {
      number(value);
    }
  }
  /// A covariance that nobody knows: zeros, and `first` as its first number.
  void covariance(std::size_t count, double first = 0.0) {
    number(first);
    for (std::size_t k = 1; k < count; ++k) {
      number(0.0);
    }
  }
  /// std_msgs/Header. @throws std::invalid_argument for a time that ROS 2 cannot stamp
  void header(std::int64_t t_ns, std::string_view frame) {
    constexpr std::int64_t kSecond = 1'000'000'000;
    if (t_ns < 0 || t_ns / kSecond > std::numeric_limits<std::int32_t>::max()) {
      throw std::invalid_argument("ROS 2 stamps lie between the years 1970 and 2038, not at " +
                                  std::to_string(t_ns) + " ns");
    }
    number(static_cast<std::int32_t>(t_ns / kSecond));
    number(static_cast<std::uint32_t>(t_ns % kSecond));
    text(frame);
  }

  [[nodiscard]] std::vector<std::uint8_t> take() { return std::move(bytes_); }

 private:
  std::vector<std::uint8_t> bytes_;
};

}  // namespace limber::detail
