// SPDX-License-Identifier: MIT
#include "limber/frontend/image_reader.hpp"

#include <opencv2/core.hpp>

#include "frontend/image_file.hpp"

namespace limber {

OwnedImage ImageReader::read(const std::filesystem::path& file) {
  cv::Mat image = frontend::read_grey(file, camera_);
  OwnedImage result{image.cols, image.rows, {}};
  result.pixels.resize(image.total());
  cv::Mat pixels(image.rows, image.cols, CV_8U, result.pixels.data());
  if (image.depth() == CV_16U) {
    double largest = 0.0;
    cv::minMaxLoc(image, nullptr, &largest);
    while (largest >= static_cast<double>(1 << bits_)) bits_ += 2;
    image.convertTo(pixels, CV_8U, 1.0 / (1 << (bits_ - 8)), bits_ > 8 ? -0.5 : 0.0);  // rounds down
  } else {
    image.copyTo(pixels);
  }
  return result;
}

}  // namespace limber
