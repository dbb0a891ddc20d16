// SPDX-License-Identifier: MIT
#include "frontend/image_file.hpp"

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <system_error>

#include "limber/core/errors.hpp"

namespace limber::frontend {

std::string size_text(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height) + " px";
}

cv::Mat read_grey(const std::filesystem::path& file, const Camera& camera) {
  const std::string expected = "an image of " + size_text(camera.width, camera.height);
  std::error_code no_error_wanted;
  std::ifstream in(file, std::ios::binary);
  if (!in || !std::filesystem::is_regular_file(file, no_error_wanted)) {
    throw DataError(file.string(), 0, expected, "no readable file");
  }
  std::ostringstream content;
  content << in.rdbuf();
  const std::string bytes = content.str();
  cv::Mat image;
  try {
    const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data()));
    // A camera's pixels stay where they are, whatever the file says about how to turn them for viewing.
    if (!bytes.empty()) image = cv::imdecode(encoded, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    image.release();  // what OpenCV refuses to decode is no image to us
  }
  if (image.empty()) throw DataError(file.string(), 0, expected, "nothing that can be decoded as an image");
  if (image.cols != camera.width || image.rows != camera.height) {
    throw DataError(file.string(), 0, expected + " (the calibration's resolution)",
                    size_text(image.cols, image.rows));
  }
  return image;
}

}  // namespace limber::frontend
