// SPDX-License-Identifier: MIT
#include "frontend/pyramid.hpp"

#include <opencv2/imgproc.hpp>

namespace limber::frontend {

Pyramid pyramid_of(const cv::Mat& image) {
  Pyramid pyramid;
  cv::buildPyramid(image, pyramid, kPyramidLevels - 1);
  return pyramid;
}

GreyImage view_of(const cv::Mat& image) {
  return {image.cols, image.rows, static_cast<std::ptrdiff_t>(image.step[0]), image.data};
}

}  // namespace limber::frontend
