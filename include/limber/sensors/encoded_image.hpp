// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace limber {

/// An image as a camera driver recorded it: pixels in some encoding, or the bytes of a PNG or JPEG file.
struct EncodedImage {
  std::string encoding;            ///< of sensor_msgs/Image (mono8, bgr8, bayer_rggb8, ...); empty for a file
  int width = 0, height = 0;       ///< [px]; 0 for a file
  std::size_t step = 0;            ///< bytes from one row to the next; 0 for a file
  bool big_endian = false;         ///< of pixels of 16 bits
  int bits = 16;                   ///< of 16, how many the camera uses
  std::vector<std::uint8_t> data;  ///< `height` rows of `step` bytes, or the whole file
};

/// Stereo images that are read when they are asked for.
class ImageStore {
 public:
  virtual ~ImageStore() = default;
  /// @param camera 0 or 1
  /// @param pair   index of the stereo pair
  /// @throws DataError (file, where in it) if it cannot be read any more
  [[nodiscard]] virtual EncodedImage load(std::size_t camera, std::size_t pair) const = 0;
  /// Where it comes from, for messages: "FILE, topic /cam0/image_raw, t = ... ns".
  [[nodiscard]] virtual std::string place(std::size_t camera, std::size_t pair) const = 0;
};

}  // namespace limber
