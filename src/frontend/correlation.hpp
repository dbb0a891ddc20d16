// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core/mat.hpp>

namespace limber::frontend {

/// @brief Normalised cross-correlation of `square` with each place of `image` where it fits.
/// What cv::matchTemplate calls TM_CCOEFF_NORMED, in a fraction of its time for squares of ten pixels.
/// @param image, square  8 bit grey
/// @return values in [-1, 1], 0 where one of the two is plain; empty if the square does not fit
[[nodiscard]] cv::Mat1f correlation(const cv::Mat1b& image, const cv::Mat1b& square);

}  // namespace limber::frontend
