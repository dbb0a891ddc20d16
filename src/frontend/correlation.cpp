// SPDX-License-Identifier: MIT
#include "frontend/correlation.hpp"

#include <Eigen/Core>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace limber::frontend {
namespace {

constexpr int kLanes = 32;              ///< places that are worked on together
constexpr double kPlainVariance = 1.0;  ///< [grey level^2] below it nothing can be said

/// The square without its mean, of length 1; zero where it is plain.
cv::Mat1f unit_pattern(const cv::Mat1b& square) {
  cv::Scalar mean, deviation;
  cv::meanStdDev(square, mean, deviation);
  const double area = static_cast<double>(square.total());
  cv::Mat1f pattern;
  if (deviation[0] * deviation[0] < kPlainVariance) return cv::Mat1f::zeros(square.size());
  const double scale = 1.0 / (deviation[0] * std::sqrt(area));
  square.convertTo(pattern, CV_32F, scale, -scale * mean[0]);
  return pattern;
}

}  // namespace

cv::Mat1f correlation(const cv::Mat1b& image, const cv::Mat1b& square) {
  const int columns = image.cols - square.cols + 1, rows = image.rows - square.rows + 1;
  if (columns < 1 || rows < 1) return {};
  const int whole = (columns + kLanes - 1) / kLanes * kLanes;
  cv::Mat1f grey(image.rows, whole + square.cols - 1, 0.0f), map(rows, whole);
  cv::Mat inside = grey(cv::Rect({}, image.size()));
  image.convertTo(inside, CV_32F);
  const cv::Mat1f pattern = unit_pattern(square);
  cv::Mat1d sum, sum_of_squares;
  cv::integral(image, sum, sum_of_squares, CV_64F, CV_64F);
  const auto over_square = [&](const cv::Mat1d& integral, int v, int u) {
    const int below = v + square.rows, right = u + square.cols;
    return integral(below, right) - integral(v, right) - integral(below, u) + integral(v, u);
  };
  using Lanes = Eigen::Array<float, kLanes, 1>;
  const double area = static_cast<double>(square.total());
  for (int v = 0; v < rows; ++v) {
    for (int u = 0; u < whole; u += kLanes) {
      Lanes products = Lanes::Zero();
      for (int y = 0; y < square.rows; ++y) {
        for (int x = 0; x < square.cols; ++x) {
          products += pattern(y, x) * Eigen::Map<const Lanes>(&grey(v + y, u + x));
        }
      }
      Eigen::Map<Lanes>(&map(v, u)) = products;
    }
    for (int u = 0; u < columns; ++u) {
      const double mean = over_square(sum, v, u) / area;
      const double variance = over_square(sum_of_squares, v, u) / area - mean * mean;
      map(v, u) =
          variance < kPlainVariance ? 0.0f : map(v, u) / static_cast<float>(std::sqrt(variance * area));
    }
  }
  return map.colRange(0, columns);
}

}  // namespace limber::frontend
