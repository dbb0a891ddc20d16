// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <bit>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/numbers.hpp"
#include "limber/bags/bag_file.hpp"
#include "limber/core/pose.hpp"

namespace limber::detail {

/// Fields of a ROS message, one after another: ROS 1 (packed) or CDR (aligned), both little-endian.
class MessageWriter {
 public:
  explicit MessageWriter(Serialization serialization) : is_cdr_(serialization == Serialization::kCdr) {
    if (is_cdr_) {
      bytes_ = {0, 1, 0, 0};
    }
  }

  template <typename Number>
  void number(Number value) {
    static_assert(std::endian::native == std::endian::little);
    while (is_cdr_ && (bytes_.size() - 4) % sizeof(Number) != 0) {
      bytes_.push_back(0);
    }
    const auto* begin = reinterpret_cast<const std::uint8_t*>(&value);
    bytes_.insert(bytes_.end(), begin, begin + sizeof(Number));
  }
  void size(std::size_t count) { number(static_cast<std::uint32_t>(count)); }  ///< of a list
  void flag(bool value) { number(static_cast<std::uint8_t>(value ? 1 : 0)); }
  void text(std::string_view text) {
    size(text.size() + (is_cdr_ ? 1 : 0));
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    if (is_cdr_) {
      bytes_.push_back(0);
    }
  }
  void data(std::span<const std::uint8_t> data) {
    size(data.size());
    bytes_.insert(bytes_.end(), data.begin(), data.end());
  }
  void vector3(const Eigen::Vector3d& v) {
    for (const double value : v) {
      number(value);
    }
  }
  /// Position, then quaternion x y z w.
  void pose(const Pose& T) {
    vector3(T.p);
    const Eigen::Vector4d wxyz = quaternion_wxyz(T.R);
    for (const int k : {1, 2, 3, 0}) {
      number(wxyz(k));
    }
  }
  /// A covariance that nobody knows: zeros, and `first` as its first number.
  void unknown_covariance(std::size_t count, double first = 0.0) {
    number(first);
    for (std::size_t k = 1; k < count; ++k) {
      number(0.0);
    }
  }
  /// std_msgs/Header. @throws std::invalid_argument for a time that cannot be stamped
  void header(std::int64_t t_ns, std::string_view frame) {
    constexpr std::int64_t kSecond = 1'000'000'000;
    const std::int64_t latest = is_cdr_ ? std::numeric_limits<std::int32_t>::max()
                                        : std::int64_t{std::numeric_limits<std::uint32_t>::max()};
    if (t_ns < 0 || t_ns / kSecond > latest) {
      throw std::invalid_argument(
          std::string("stamps of ROS ") +
          (is_cdr_ ? "2 lie between the years 1970 and 2038" : "1 lie between the years 1970 and 2106") +
          ", not at " + std::to_string(t_ns) + " ns");
    }
    if (!is_cdr_) {
      number(std::uint32_t{0});  // sequence number
    }
    number(static_cast<std::uint32_t>(t_ns / kSecond));
    number(static_cast<std::uint32_t>(t_ns % kSecond));
    text(frame);
  }

  [[nodiscard]] std::vector<std::uint8_t> take() { return std::move(bytes_); }

 private:
  std::vector<std::uint8_t> bytes_;
  bool is_cdr_;
};

}  // namespace limber::detail
