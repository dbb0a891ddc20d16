// SPDX-License-Identifier: MIT
#include "frontend/correlation.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

namespace limber::frontend {
namespace {

cv::Mat1b noise(const cv::Size& size, unsigned seed) {
  cv::Mat1b image(size);
  cv::RNG(seed).fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

/// By the definition.
double correlation_of(const cv::Mat1b& x, const cv::Mat1b& y) {
  cv::Mat1d a, b;
  x.convertTo(a, CV_64F);
  y.convertTo(b, CV_64F);
  a -= cv::mean(a)[0];
  b -= cv::mean(b)[0];
  return a.dot(b) / (cv::norm(a) * cv::norm(b));
}

cv::Mat1f correlation(const cv::Mat1b& image, const cv::Mat1b& square) {
  return CorrelationImage(image, square.size()).correlate(square, cv::Rect({}, image.size()));
}

TEST(Correlation, IsThatOfEachPlaceOfTheImage) {
  const cv::Mat1b image = noise({57, 31}, 1);
  for (const cv::Size size : {cv::Size(11, 11), cv::Size(3, 8), cv::Size(57, 31)}) {
    const cv::Mat1b square = noise(size, 2);
    const cv::Mat1f map = correlation(image, square);
    ASSERT_EQ(map.size(), cv::Size(image.cols - size.width + 1, image.rows - size.height + 1));
    for (int v = 0; v < map.rows; ++v) {
      for (int u = 0; u < map.cols; ++u) {
        EXPECT_NEAR(map(v, u), correlation_of(image(cv::Rect({u, v}, size)), square), 1e-5) << u << " " << v;
      }
    }
  }
}

TEST(Correlation, OfAnAreaIsThatOfTheWholeThere) {
  const cv::Mat1b image = noise({57, 31}, 7), square = noise({11, 11}, 8);
  const CorrelationImage searched(image, square.size());
  const cv::Mat1f whole = searched.correlate(square, cv::Rect({}, image.size()));
  for (const cv::Rect& area : {cv::Rect(0, 0, 11, 11), cv::Rect(9, 4, 30, 20), cv::Rect(46, 20, 11, 11)}) {
    const cv::Mat1f part = searched.correlate(square, area);
    EXPECT_EQ(cv::norm(part - whole(cv::Rect(area.tl(), part.size())), cv::NORM_INF), 0.0);
  }
  EXPECT_TRUE(searched.correlate(square, cv::Rect(0, 0, 10, 31)).empty());
}

TEST(Correlation, IsOneWhereTheSquareWasCutWhateverTheBrightness) {
  const cv::Mat1b image = noise({80, 40}, 3);
  const cv::Mat1b darker = image / 3 + 7;
  EXPECT_NEAR(correlation(darker, image(cv::Rect(61, 22, 11, 11)))(22, 61), 1.0f, 1e-3f);
}

TEST(Correlation, IsZeroWhereThereIsNothingToCompare) {
  cv::Mat1b image = noise({40, 20}, 4);
  image(cv::Rect(0, 0, 15, 20)).setTo(255);
  const cv::Mat1b square = noise({9, 9}, 5);
  EXPECT_EQ(correlation(image, square)(5, 3), 0.0f);
  EXPECT_EQ(cv::countNonZero(correlation(image, cv::Mat1b(9, 9, std::uint8_t{80}))), 0);
  EXPECT_TRUE(correlation(image, noise({41, 9}, 6)).empty());
}

}  // namespace
}  // namespace limber::frontend
