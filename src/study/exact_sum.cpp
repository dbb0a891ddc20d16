// SPDX-License-Identifier: MIT
#include "limber/study/exact_sum.hpp"

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

namespace limber {
namespace {

static_assert(std::endian::native == std::endian::little, "databases hold sums in little endian");

constexpr int kTermBits = std::bit_width(kMaxTerms) - 1;

void check_frames(std::size_t expected, std::size_t found) {
  if (expected != found) {
    throw std::invalid_argument("curve: " + std::to_string(expected) + " frames, got " +
                                std::to_string(found));
  }
}

}  // namespace

int fraction_bits(CurveQuantity quantity) {
  switch (quantity) {
    case CurveQuantity::kLandmarkSquaredError:
    case CurveQuantity::kLandmarks:
    case CurveQuantity::kPoseNees:
    case CurveQuantity::kPositionNees:
    case CurveQuantity::kAttitudeNees:
      return 40;
    default:
      return 80;
  }
}

std::optional<Int128> to_fixed(double value, int bits) {
  if (!(std::abs(value) < std::ldexp(1.0, 127 - kTermBits - bits))) {
    return std::nullopt;
  }
  return static_cast<Int128>(std::rint(std::ldexp(value, bits)));
}

double from_fixed(Int128 value, int bits) { return std::ldexp(static_cast<double>(value), -bits); }

CurveSum::CurveSum(CurveQuantity quantity, std::size_t frames)
    : bits_(fraction_bits(quantity)), sums_(frames), counts_(frames) {}

CurveSum::CurveSum(CurveQuantity quantity, std::string_view bytes)
    : CurveSum(quantity, bytes.size() / kBytesPerFrame) {
  check_frames(sums_.size() * kBytesPerFrame, bytes.size());
  const std::size_t split = sums_.size() * sizeof(Int128);
  std::memcpy(sums_.data(), bytes.data(), split);
  std::memcpy(counts_.data(), bytes.data() + split, bytes.size() - split);
}

void CurveSum::add(const std::vector<double>& values) {
  check_frames(sums_.size(), values.size());
  std::vector<Int128> terms;
  for (const double value : values) {
    const std::optional<Int128> term = std::isnan(value) ? Int128{0} : to_fixed(value, bits_);
    if (!term) {
      throw std::invalid_argument("curve: " + std::to_string(value) + " is out of range");
    }
    terms.push_back(*term);
  }
  for (std::size_t k = 0; k < terms.size(); ++k) {
    sums_[k] += terms[k];
    counts_[k] += std::isnan(values[k]) ? 0 : 1;
  }
}

void CurveSum::add(const CurveSum& other) {
  check_frames(sums_.size(), other.sums_.size());
  for (std::size_t k = 0; k < sums_.size(); ++k) {
    sums_[k] += other.sums_[k];
    counts_[k] += other.counts_[k];
  }
}

StudyCurve CurveSum::curve() const {
  StudyCurve out;
  out.count = counts_;
  for (std::size_t k = 0; k < sums_.size(); ++k) {
    out.mean.push_back(counts_[k] > 0 ? from_fixed(sums_[k], bits_) / static_cast<double>(counts_[k])
                                      : std::numeric_limits<double>::quiet_NaN());
  }
  return out;
}

std::string CurveSum::to_bytes() const {
  const std::size_t split = sums_.size() * sizeof(Int128);
  std::string bytes(split + counts_.size() * sizeof(std::uint64_t), '\0');
  std::memcpy(bytes.data(), sums_.data(), split);
  std::memcpy(bytes.data() + split, counts_.data(), bytes.size() - split);
  return bytes;
}

}  // namespace limber
