// SPDX-License-Identifier: MIT
#include "rig_files/opencv_lens.hpp"

#include <algorithm>

namespace limber::detail {
namespace {

constexpr std::size_t kTangential = 4, kThird = 5, kRational = 8;  // how many coefficients

bool all_zero(const std::vector<double>& values, std::size_t from) {
  return std::all_of(values.begin() + static_cast<std::ptrdiff_t>(from), values.end(),
                     [](double value) { return value == 0.0; });
}

}  // namespace

std::optional<std::vector<double>> opencv_coefficients(const Distortion& distortion) {
  if (std::holds_alternative<NoDistortion>(distortion)) {
    return std::vector<double>(kTangential, 0.0);
  }
  std::vector<double> out = coefficients(distortion);
  if (std::holds_alternative<RadialTangential>(distortion)) {
    return out;
  }
  if (!std::holds_alternative<Rational>(distortion)) {
    return std::nullopt;
  }
  out.resize(all_zero(out, kThird) ? kThird : kRational);
  return out;
}

Distortion opencv_lens(const std::vector<double>& coefficients) {
  std::vector<double> k = coefficients;
  k.resize(kRational);
  if (all_zero(k, kTangential)) {
    return RadialTangential{k[0], k[1], k[2], k[3]};
  }
  return with_coefficients(Rational{}, k);
}

}  // namespace limber::detail
