// SPDX-License-Identifier: MIT
#include "io/numbers.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "limber/core/so3.hpp"

namespace limber::detail {
namespace {

constexpr double kQuaternionNormTolerance = 1e-2;
constexpr std::int64_t kLargestExponent = 30;

template <typename T>
std::optional<T> parse_whole(std::string_view text) {
  if (text.starts_with('+')) {
    text.remove_prefix(1);
    if (text.starts_with('-')) {
      return std::nullopt;
    }
  }
  T value{};
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc{} || stop != end) {
    return std::nullopt;
  }
  return value;
}

// round(digits * 10^scale), digits a string of decimal digits.
std::optional<std::int64_t> scaled_integer(std::string digits, std::int64_t scale) {
  bool round_up = false;
  if (scale >= 0) {
    digits.append(static_cast<std::size_t>(scale), '0');
  } else {
    const auto cut = static_cast<std::size_t>(-scale);
    round_up = cut <= digits.size() && digits[digits.size() - cut] >= '5';
    digits.erase(digits.size() - std::min(cut, digits.size()));
  }
  const auto value = digits.empty() ? std::optional<std::int64_t>(0) : parse_integer(digits);
  if (!value || *value == std::numeric_limits<std::int64_t>::max()) {
    return std::nullopt;
  }
  return *value + (round_up ? 1 : 0);
}

}  // namespace

std::optional<double> parse_number(std::string_view text) { return parse_whole<double>(text); }

std::optional<std::int64_t> parse_integer(std::string_view text) { return parse_whole<std::int64_t>(text); }

std::optional<std::int64_t> parse_seconds_as_ns(std::string_view text) {
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) {
    text.remove_prefix(1);
  }
  std::string digits;
  std::int64_t scale = 9;
  bool in_fraction = false;
  std::size_t k = 0;
  for (; k < text.size(); ++k) {
    if (text[k] >= '0' && text[k] <= '9') {
      digits += text[k];
      scale -= in_fraction ? 1 : 0;
    } else if (text[k] == '.' && !in_fraction) {
      in_fraction = true;
    } else {
      break;
    }
  }
  if (digits.empty()) {
    return std::nullopt;
  }
  if (k < text.size()) {
    const bool marked = text[k] == 'e' || text[k] == 'E';
    const auto exponent = marked ? parse_integer(text.substr(k + 1)) : std::nullopt;
    if (!exponent || *exponent > kLargestExponent || *exponent < -kLargestExponent) {
      return std::nullopt;
    }
    scale += *exponent;
  }
  const auto value = scaled_integer(std::move(digits), scale);
  return value && negative ? std::optional<std::int64_t>(-*value) : value;
}

std::string format_ns_as_seconds(std::int64_t t_ns) {
  constexpr std::uint64_t kSecond = 1'000'000'000;
  const auto bits = static_cast<std::uint64_t>(t_ns);
  const std::uint64_t magnitude = t_ns < 0 ? ~bits + 1 : bits;
  return fmt::format("{}{}.{:09}", t_ns < 0 ? "-" : "", magnitude / kSecond, magnitude % kSecond);
}

std::string excerpt(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  std::string result = "'";
  for (const char c : text.substr(0, kLongest)) {
    const auto byte = static_cast<unsigned char>(c);
    result += byte >= 0x20 && byte < 0x7f ? std::string(1, c) : fmt::format("\\x{:02x}", byte);
  }
  return result + (text.size() > kLongest ? "...'" : "'");
}

std::optional<Eigen::Matrix3d> checked_rotation(const Eigen::Matrix3d& R) {
  if (!is_rotation(R)) {
    return std::nullopt;
  }
  return so3_normalized(R);
}

std::optional<Eigen::Matrix3d> checked_quaternion(const Eigen::Vector4d& wxyz) {
  if (!(std::abs(wxyz.norm() - 1.0) < kQuaternionNormTolerance)) {
    return std::nullopt;
  }
  return Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]).normalized().toRotationMatrix();
}

bool is_focal_length(double f) { return f >= 1e-3 && f <= 1e6; }

Eigen::Vector4d quaternion_wxyz(const Eigen::Matrix3d& R) {
  const Eigen::Quaterniond q = Eigen::Quaterniond(R).normalized();
  const Eigen::Vector4d wxyz(q.w(), q.x(), q.y(), q.z());
  return q.w() < 0.0 ? Eigen::Vector4d(-wxyz) : wxyz;
}

}  // namespace limber::detail
