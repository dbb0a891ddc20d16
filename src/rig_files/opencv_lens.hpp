// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "limber/sensors/distortion.hpp"

/// Lenses as OpenCV's pinhole camera lists them: k1 k2 p1 p2 [k3 [k4 k5 k6]].
namespace limber::detail {

/// 4, 5 or 8 coefficients, as few as say the lens; nothing where OpenCV's pinhole camera has no such lens.
[[nodiscard]] std::optional<std::vector<double>> opencv_coefficients(const Distortion& distortion);

/// The lens of 4, 5 or 8 coefficients.
[[nodiscard]] Distortion opencv_lens(const std::vector<double>& coefficients);

}  // namespace limber::detail
