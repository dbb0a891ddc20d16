// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "limber/frontend/grey_image.hpp"

namespace limber {

/// @brief A JPEG file of an image, made smaller by whole-pixel means if it is wider than `most_width` [px].
/// @param quality  1 ... 100
/// @throws std::invalid_argument for an empty image
[[nodiscard]] std::vector<std::uint8_t> encode_jpeg(const GreyImage& image, int quality, int most_width);

}  // namespace limber
