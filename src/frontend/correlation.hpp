// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core/mat.hpp>

namespace limber::frontend {

/// @brief An image in which squares of one size are looked for: what all of them share is worked out once.
///
/// Normalised cross-correlation, what cv::matchTemplate calls TM_CCOEFF_NORMED, in a fraction of its time for
/// squares of ten pixels.
class CorrelationImage {
 public:
  /// @param image   8 bit grey
  /// @param square  size of what is looked for
  CorrelationImage(const cv::Mat1b& image, const cv::Size& square);

  [[nodiscard]] const cv::Size& size() const { return size_; }

  /// @param square  8 bit grey, of the size that was said
  /// @param area    of the image, inside of it
  /// @return values in [-1, 1] for each place of the area where the square fits, 0 where one of the two is
  /// plain; empty if it fits nowhere
  [[nodiscard]] cv::Mat1f correlate(const cv::Mat1b& square, const cv::Rect& area) const;

 private:
  cv::Size size_, square_;
  cv::Mat1f grey_;   // wider and higher than the image, so that blocks of places may end beyond it
  cv::Mat1f norms_;  // of what the square would lie on, without its mean; infinite where that is plain
};

}  // namespace limber::frontend
