// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

namespace limber {

/// @brief A grey picture without end: a square of kSide texels that repeats, drawn from a seed: noise of many
/// sizes, with discs and bars upon it. Grey levels from 16 to 240.
class Texture {
 public:
  static constexpr int kSide = 1024;  ///< texels

  /// @param seed  the same one makes the same picture
  explicit Texture(std::uint64_t seed);

  /// The same picture with its contrast times `contrast`, around the grey level `mean`.
  [[nodiscard]] Texture faded(float contrast, float mean) const;

  /// Grey value at (x, y) [texels], seen by a pixel that is 2^lod texels wide: linear between texels, and
  /// between the levels of a pyramid of means.
  [[nodiscard]] float at(float x, float y, float lod) const;

 private:
  [[nodiscard]] float bilinear(std::size_t level, float x, float y) const;

  std::vector<std::vector<float>> levels_;
};

}  // namespace limber
