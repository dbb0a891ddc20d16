// SPDX-License-Identifier: MIT
#include "frontend/image_file.hpp"

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <string_view>
#include <system_error>

#include "io/image_size.hpp"
#include "limber/core/errors.hpp"

namespace limber::frontend {

std::string size_text(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height) + " px";
}

namespace {

/// A PNG file without its end: cut off while it was written or copied.
bool is_torn_png(std::string_view bytes) {
  constexpr std::size_t kEndChunk = 12;
  return bytes.starts_with("\x89PNG") &&
         (bytes.size() < kEndChunk ||
          bytes.substr(bytes.size() - kEndChunk).find("IEND") == std::string::npos);
}

cv::Mat decode(std::string_view bytes, int width, int height, const std::string& name, int flags) {
  const std::string expected = "an image of " + size_text(width, height);
  if (is_torn_png(bytes)) throw DataError(name, 0, expected, "a PNG file that was cut off");
  // Before the pixels are unpacked: a small file can hold a picture that fills the memory.
  std::istringstream header{std::string(bytes)};
  if (const auto size = detail::image_size_of(header);
      size && (size->width != width || size->height != height)) {
    throw DataError(name, 0, expected + " (the calibration's resolution)",
                    size_text(size->width, size->height));
  } else if (!size) {
    throw DataError(name, 0, expected, "nothing that can be decoded as an image: no PNG or JPEG");
  }
  cv::Mat image;
  try {
    const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data()));
    if (!bytes.empty()) image = cv::imdecode(encoded, flags);
  } catch (const cv::Exception&) {
    image.release();  // what OpenCV refuses to decode is no image to us
  }
  if (image.empty()) throw DataError(name, 0, expected, "nothing that can be decoded as an image");
  if (image.depth() != CV_8U && image.depth() != CV_16U) {
    throw DataError(name, 0, expected + " of 8 or 16 bit", "other numbers as pixels");
  }
  if (image.cols != width || image.rows != height) {
    throw DataError(name, 0, expected + " (the calibration's resolution)", size_text(image.cols, image.rows));
  }
  return image;
}

cv::Mat read(const std::filesystem::path& file, const Camera& camera, int flags) {
  std::error_code no_error_wanted;
  std::ifstream in(file, std::ios::binary);
  if (!in || !std::filesystem::is_regular_file(file, no_error_wanted)) {
    throw DataError(file.string(), 0, "an image of " + size_text(camera.width, camera.height),
                    "no readable file");
  }
  std::ostringstream content;
  content << in.rdbuf();
  return decode(content.view(), camera.width, camera.height, file.string(), flags);
}

}  // namespace

// A camera's pixels stay where they are, whatever the file says about how to turn them for viewing.

cv::Mat grey_of_file(std::string_view bytes, int width, int height, const std::string& name) {
  return decode(bytes, width, height, name, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
}

cv::Mat read_grey(const std::filesystem::path& file, const Camera& camera) {
  return read(file, camera, cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH | cv::IMREAD_IGNORE_ORIENTATION);
}

cv::Mat read_unchanged(const std::filesystem::path& file, const Camera& camera) {
  return read(file, camera, cv::IMREAD_ANYCOLOR | cv::IMREAD_ANYDEPTH | cv::IMREAD_IGNORE_ORIENTATION);
}

}  // namespace limber::frontend
