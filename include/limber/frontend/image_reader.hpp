// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

#include "limber/frontend/grey_image.hpp"
#include "limber/images/picture.hpp"
#include "limber/sensors/camera.hpp"
#include "limber/sensors/encoded_image.hpp"

namespace limber {

/// @brief Reads the images of one camera as 8 bit grey: PNG, JPEG, TIFF, PGM and PPM, 8 or 16 bit, grey or
/// colour.
/// Of 16 bit images the highest 8 bits in use are kept: 8, 10, 12, 14 or 16 bits, by the largest value so
/// far.
class ImageReader {
 public:
  /// @param camera  whose resolution the images must have
  explicit ImageReader(Camera camera) : camera_(std::move(camera)) {}

  /// @throws DataError if the file cannot be read as an image, or has not the camera's resolution
  [[nodiscard]] GreyPixels read(const std::filesystem::path& file);

  /// @brief The same of an image as it was recorded; of pixels without a file EncodedImage::bits count.
  /// @param place  for messages
  /// @throws DataError as above, and as decode_grey
  [[nodiscard]] GreyPixels read(const EncodedImage& image, const std::string& place);

 private:
  [[nodiscard]] GreyPixels grey_of(Picture picture);

  Camera camera_;
  int bits_ = 8;  ///< in use in 16 bit images so far
};

}  // namespace limber
