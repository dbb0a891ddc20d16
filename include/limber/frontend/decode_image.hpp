// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "limber/frontend/grey_image.hpp"
#include "limber/sensors/encoded_image.hpp"

namespace limber {

/// @brief Grey of an image as it was recorded: mono8, mono16, 8UC1, 16UC1, rgb8, bgr8, rgba8, bgra8, 8UC3,
/// 8UC4, Bayer of 8 and 16 bits, YUV 4:2:2 (its Y), and PNG or JPEG files. Of 16 bits the highest eight of
/// EncodedImage::bits are kept.
/// @param place  for messages
/// @throws DataError for another encoding, data too short, or a file that is no image
[[nodiscard]] GreyPixels decode_grey(const EncodedImage& image, const std::string& place);

/// @brief Width and height of an image as it was recorded, without unpacking it.
/// @throws DataError for a file that is neither PNG nor JPEG
[[nodiscard]] std::pair<int, int> size_of(const EncodedImage& image, const std::string& place);

/// @brief A PNG file of the image: its pixels as they are, 8 or 16 bits, grey or colour. A Bayer pattern
/// stays one (grey).
/// @throws DataError as decode_grey; for encodings that PNG cannot hold (YUV)
[[nodiscard]] std::vector<std::uint8_t> encode_png(const EncodedImage& image, const std::string& place);

}  // namespace limber
