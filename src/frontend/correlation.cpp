// SPDX-License-Identifier: MIT
#include "frontend/correlation.hpp"

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace limber::frontend {
namespace {

constexpr int kLanes = 16, kRows = 2;   ///< places beside and below each other that are worked on together
constexpr double kPlainVariance = 1.0;  ///< [grey level^2] below it nothing can be said

using Lanes = Eigen::Array<float, kLanes, 1>;

int rounded_up(int size, int block) { return (size + block - 1) / block * block; }

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

/// Length of the part of the image below the square, without its mean, for each place.
cv::Mat1f norms_below(const cv::Mat1b& image, const cv::Size& square) {
  cv::Mat1d sum, sum_of_squares;
  cv::integral(image, sum, sum_of_squares, CV_64F, CV_64F);
  const double area = square.area();
  cv::Mat1f norms(image.rows - square.height + 1, image.cols - square.width + 1);
  for (int v = 0; v < norms.rows; ++v) {
    for (int u = 0; u < norms.cols; ++u) {
      const auto over_square = [&](const cv::Mat1d& integral) {
        const int below = v + square.height, right = u + square.width;
        return integral(below, right) - integral(v, right) - integral(below, u) + integral(v, u);
      };
      const double mean = over_square(sum) / area;
      const double variance = over_square(sum_of_squares) / area - mean * mean;
      norms(v, u) = variance < kPlainVariance ? std::numeric_limits<float>::infinity()
                                              : static_cast<float>(std::sqrt(variance * area));
    }
  }
  return norms;
}

/// The pattern's products with a block of places, the first of which is at (u, v) of the image.
void multiply_block(const cv::Mat1f& pattern, const cv::Mat1f& grey, int u, int v, cv::Mat1f& map,
                    const cv::Point& to) {
  std::array<Lanes, kRows> products;
  products.fill(Lanes::Zero());
  for (int y = 0; y < pattern.rows; ++y) {
    for (int x = 0; x < pattern.cols; ++x) {
      for (int row = 0; row < kRows; ++row) {
        products[static_cast<std::size_t>(row)] +=
            pattern(y, x) * Eigen::Map<const Lanes>(&grey(v + y + row, u + x));
      }
    }
  }
  for (int row = 0; row < kRows; ++row) {
    Eigen::Map<Lanes>(&map(to.y + row, to.x)) = products[static_cast<std::size_t>(row)];
  }
}

}  // namespace

CorrelationImage::CorrelationImage(const cv::Mat1b& image, const cv::Size& square)
    : size_(image.size()), square_(square), grey_(image.rows + kRows - 1, image.cols + kLanes - 1, 0.0f) {
  cv::Mat inside = grey_(cv::Rect({}, size_));
  image.convertTo(inside, CV_32F);
  if (square.width <= image.cols && square.height <= image.rows) {
    norms_ = norms_below(image, square);
  }
}

cv::Mat1f CorrelationImage::correlate(const cv::Mat1b& square, const cv::Rect& area) const {
  const int columns = area.width - square_.width + 1, rows = area.height - square_.height + 1;
  if (columns < 1 || rows < 1) return {};
  cv::Mat1f map(rounded_up(rows, kRows), rounded_up(columns, kLanes));
  const cv::Mat1f pattern = unit_pattern(square);
  for (int v = 0; v < rows; v += kRows) {
    for (int u = 0; u < columns; u += kLanes) {
      multiply_block(pattern, grey_, area.x + u, area.y + v, map, {u, v});
    }
  }
  for (int v = 0; v < rows; ++v) {
    Eigen::Map<Eigen::ArrayXf>(map[v], columns) /=
        Eigen::Map<const Eigen::ArrayXf>(norms_[area.y + v] + area.x, columns);
  }
  return map(cv::Rect(0, 0, columns, rows));
}

}  // namespace limber::frontend
