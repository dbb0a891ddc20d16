// SPDX-License-Identifier: MIT
#include "frontend/corners.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <set>

#include "frontend/painted_room.hpp"

namespace limber::frontend {
namespace {

using limber::testing::Image;

cv::Mat as_matrix(const Image& image) {
  return cv::Mat(image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.pixels.data()));
}

const CornerOptions kOptions{60, 15.0, 15.0, 12};

Image room() {
  return limber::testing::photograph(limber::testing::small_rig().cam0, limber::testing::flight(0), {});
}

TEST(NewCorners, AreManySpreadAndApart) {
  const Image image = room();
  const auto corners = new_corners(as_matrix(image), {}, kOptions);
  EXPECT_EQ(corners.size(), 60u);
  std::set<int> tiles;  // of 4 x 3
  for (std::size_t i = 0; i < corners.size(); ++i) {
    EXPECT_GE(corners[i].minCoeff(), kOptions.border);
    EXPECT_LE(corners[i].x(), image.width - kOptions.border);
    EXPECT_LE(corners[i].y(), image.height - kOptions.border);
    tiles.insert(static_cast<int>(corners[i].x() * 4 / image.width) * 3 +
                 static_cast<int>(corners[i].y() * 3 / image.height));
    // The sub-pixel refinement may move two neighbours towards each other, by its window of 5 px each.
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_GT((corners[i] - corners[j]).norm(), kOptions.min_distance - 10.0);
  }
  EXPECT_EQ(tiles.size(), 12u);
}

TEST(NewCorners, FillOnlyWhereRoomIsLeft) {
  const Image image = room();
  const auto all = new_corners(as_matrix(image), {}, kOptions);
  std::vector<Eigen::Vector2d> left_half;
  for (const Eigen::Vector2d& uv : all) {
    if (uv.x() < 0.5 * image.width) left_half.push_back(uv);
  }
  const auto more = new_corners(as_matrix(image), left_half, kOptions);
  EXPECT_EQ(more.size() + left_half.size(), 60u);
  int on_the_right = 0;
  for (const Eigen::Vector2d& uv : more) {
    on_the_right += uv.x() > 0.5 * image.width - 5.0;
    for (const Eigen::Vector2d& taken : left_half)
      EXPECT_GT((uv - taken).norm(), kOptions.min_distance - 5.0);
  }
  EXPECT_GE(on_the_right, static_cast<int>(more.size()) - 2);
  EXPECT_TRUE(new_corners(as_matrix(image), all, kOptions).empty());
}

TEST(NewCorners, SitOnACornerToAFractionOfAPixel) {
  Image image = limber::testing::plain_image(128, 96, 40);
  for (int v = 48; v < 96; ++v) {
    for (int u = 64; u < 128; ++u) image.pixels[static_cast<std::size_t>(v * 128 + u)] = 200;
  }
  const auto corners = new_corners(as_matrix(image), {}, kOptions);
  ASSERT_EQ(corners.size(), 1u);
  EXPECT_LT((corners[0] - Eigen::Vector2d(63.5, 47.5)).norm(), 0.1);
}

TEST(NewCorners, AreAsStrongAsTheStructureTensorSays) {
  const Image image = room();
  cv::Mat strength;  // OpenCV's scale for 8 bit images, Sobel of size 3
  cv::cornerMinEigenVal(as_matrix(image), strength, 5, 3);
  strength *= 255.0 * 255.0 / 4.0;
  const cv::Rect inner(20, 20, image.width - 40, image.height - 40);
  double largest = 0.0;
  cv::minMaxLoc(strength(inner), nullptr, &largest);
  const CornerOptions in_one_cell{3, 15.0, 0.999 * largest, 15};
  EXPECT_EQ(new_corners(as_matrix(image), {}, in_one_cell).size(), 1u);
  const CornerOptions above{3, 15.0, 1.001 * largest, 15};
  EXPECT_TRUE(new_corners(as_matrix(image), {}, above).empty());
}

TEST(NewCorners, AreNotSeenInPlainOrMerelyNoisyImages) {
  EXPECT_TRUE(new_corners(as_matrix(limber::testing::plain_image(376, 240, 0)), {}, kOptions).empty());
  Image noisy = limber::testing::plain_image(376, 240, 0);
  std::mt19937_64 generator(1);
  std::normal_distribution<double> noise(100.0, 3.0);
  for (auto& pixel : noisy.pixels) pixel = static_cast<std::uint8_t>(std::lround(noise(generator)));
  EXPECT_TRUE(new_corners(as_matrix(noisy), {}, kOptions).empty());
}

}  // namespace
}  // namespace limber::frontend
