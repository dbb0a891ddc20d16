// SPDX-License-Identifier: MIT
#include "limber/frontend/encode_jpeg.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "limber/images/picture.hpp"

namespace limber {

std::vector<std::uint8_t> encode_jpeg(const GreyImage& image, int quality, int most_width) {
  if (image.width <= 0 || image.height <= 0 || image.data == nullptr) {
    throw std::invalid_argument("encode_jpeg: the image is empty");
  }
  // OpenCV takes no pointer to const; it only reads here.
  cv::Mat pixels(image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.data),
                 static_cast<std::size_t>(image.stride));
  const int step = (image.width + most_width - 1) / most_width;
  if (step > 1) {
    cv::Mat small;
    cv::resize(pixels, small, {std::max(1, image.width / step), std::max(1, image.height / step)}, 0.0, 0.0,
               cv::INTER_AREA);
    pixels = small;
  }
  return encode_jpeg(PictureView{pixels.cols, pixels.rows, 1, 8, pixels.step, pixels.data}, quality);
}

}  // namespace limber
