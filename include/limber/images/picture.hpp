// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace limber {

/// Pixels of an image file: grey or red, green, blue side by side; row by row without gaps; 16 bits in this
/// machine's order of bytes.
struct Picture {
  int width = 0, height = 0;  ///< [px]
  int channels = 1;           ///< 1: grey, 3: red, green, blue
  int bits = 8;               ///< of a number: 8 or 16
  /// rows from the top, without gaps
  std::vector<std::uint8_t> data;

  /// Bytes of a row.
  [[nodiscard]] std::size_t stride() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(channels * bits / 8);
  }
};

/// Pixels that someone else owns, as Picture's; PNG files may also have 4 channels (the last one: alpha).
struct PictureView {
  /// [px]; 1, 3 or 4 numbers a pixel; 8 or 16 bits a number
  int width = 0, height = 0, channels = 1, bits = 8;
  std::size_t stride = 0;  ///< bytes from one row to the next
  /// of the first row
  const std::uint8_t* data = nullptr;
};

/// What becomes of colours.
enum class Colours { kKeep, kToGrey };

/// @brief The pixels of a PNG, JPEG, TIFF, PGM or PPM file, turned by nothing that the file says of how to
/// view it. Alpha is left out. Grey of colours is 0.299 R + 0.587 G + 0.114 B, of JPEG its own luminance.
/// @param file  its content
/// @param name  for messages
/// @throws DataError for another format, a file that was cut off, numbers of more than 16 bits, or more than
/// 2^28 pixels
[[nodiscard]] Picture decode_picture(std::string_view file, Colours colours, const std::string& name);

/// @brief A PNG file of these pixels, made fast rather than small.
/// @throws std::invalid_argument for what a PNG file cannot hold
[[nodiscard]] std::vector<std::uint8_t> encode_png(const PictureView& picture);

/// @brief A JPEG file of grey pixels of 8 bits.
/// @param quality  1 ... 100
/// @throws std::invalid_argument for other pixels
[[nodiscard]] std::vector<std::uint8_t> encode_jpeg(const PictureView& picture, int quality);

}  // namespace limber
