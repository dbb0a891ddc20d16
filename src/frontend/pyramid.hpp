// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "limber/frontend/grey_image.hpp"

namespace limber::frontend {

/// An image and its halvings, the full one first; pixel (u, v) is (u, v) / 2^level on each.
using Pyramid = std::vector<cv::Mat>;
inline constexpr int kPyramidLevels = 4;

[[nodiscard]] Pyramid pyramid_of(const cv::Mat& image);

/// A view on the pixels of an 8 bit grey matrix.
[[nodiscard]] GreyImage view_of(const cv::Mat& image);

}  // namespace limber::frontend
