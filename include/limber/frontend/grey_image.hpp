// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace limber {

/// A grey image that someone else owns: 8 bit, row by row. Pixel (u, v), u to the right, v down, is
/// data[v * stride + u]; its centre has the coordinates (u, v).
struct GreyImage {
  int width = 0, height = 0;  ///< [px]
  std::ptrdiff_t stride = 0;  ///< bytes from one row to the next, at least width
  /// of pixel (0, 0)
  const std::uint8_t* data = nullptr;
};

/// One that owns its pixels, row by row without gaps.
struct GreyPixels {
  int width = 0, height = 0;  ///< [px]
  /// width × height grey levels
  std::vector<std::uint8_t> data;

  /// The same image; valid as long as this one lives.
  [[nodiscard]] GreyImage view() const { return {width, height, width, data.data()}; }
};

}  // namespace limber
