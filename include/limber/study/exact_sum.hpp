// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "limber/study/curve.hpp"

/// Sums that do not depend on the order of their terms: floating-point numbers are rounded to multiples of
/// 2^-b once, each for itself, and added as 128-bit integers, which is exact and associative.
namespace limber {

/// A sum without rounding.
__extension__ typedef __int128 Int128;

/// Terms that a sum has room for.
inline constexpr std::uint64_t kMaxTerms = std::uint64_t{1} << 24;

/// Of a sum as bytes, see CurveSum::to_bytes.
inline constexpr std::size_t kBytesPerFrame = sizeof(Int128) + sizeof(std::uint64_t);

/// b: values of a quantity are multiples of 2^-b. 80 for what is metres or radians (multiples of 8e-25, below
/// 8e6); 40 for what may grow without bound (multiples of 9e-13, below 9e18).
[[nodiscard]] int fraction_bits(CurveQuantity quantity);

/// @return `value` as a multiple of 2^-bits, to nearest; nothing if it is not finite or so large that
/// kMaxTerms of it would not fit (|value| >= 2^(103 - bits))
[[nodiscard]] std::optional<Int128> to_fixed(double value, int bits);

/// The nearest double.
[[nodiscard]] double from_fixed(Int128 value, int bits);

/// @brief Sum over runs of one quantity at every stereo frame, and how many runs entered.
class CurveSum {
 public:
  /// Zeros.
  /// @param frames  stereo frames of a run
  CurveSum(CurveQuantity quantity, std::size_t frames);
  /// What to_bytes gave. @throws std::invalid_argument if there are not 24 bytes per frame
  CurveSum(CurveQuantity quantity, std::string_view bytes);

  /// @param values one per frame; NaN: the run has nothing to say of that frame
  /// @throws std::invalid_argument if the number of frames differs, or to_fixed has nothing for a value: the
  /// sum is unchanged then
  void add(const std::vector<double>& values);
  /// @throws std::invalid_argument if the number of frames differs
  void add(const CurveSum& other);

  /// Mean over the runs at every frame, with their number.
  [[nodiscard]] StudyCurve curve() const;

  /// Sums (16 bytes each, little endian), then counts (8 bytes each).
  [[nodiscard]] std::string to_bytes() const;

 private:
  int bits_;
  std::vector<Int128> sums_;
  std::vector<std::uint64_t> counts_;
};

}  // namespace limber
