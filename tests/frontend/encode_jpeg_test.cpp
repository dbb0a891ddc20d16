// SPDX-License-Identifier: MIT
#include "limber/frontend/encode_jpeg.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <stdexcept>

#include "limber/frontend/decode_image.hpp"

namespace limber {
namespace {

/// A slope of grey, brighter to the right and downwards, whose rows have a gap.
class Slope {
 public:
  Slope() : pixels_(kStride * kHeight) {
    for (std::size_t v = 0; v < kHeight; ++v) {
      for (std::size_t u = 0; u < kWidth; ++u)
        pixels_[v * kStride + u] = static_cast<std::uint8_t>(2 * u + v);
    }
  }
  [[nodiscard]] GreyImage view() const { return {kWidth, kHeight, kStride, pixels_.data()}; }

  static constexpr std::size_t kWidth = 90, kHeight = 60, kStride = 96;

 private:
  std::vector<std::uint8_t> pixels_;
};

GreyPixels decoded(const std::vector<std::uint8_t>& file) {
  EncodedImage image;
  image.data = file;
  return decode_grey(image, "test");
}

TEST(EncodeJpeg, KeepsThePicture) {
  const GreyPixels back = decoded(encode_jpeg(Slope().view(), 90, 90));
  ASSERT_EQ(back.width, 90);
  ASSERT_EQ(back.height, 60);
  for (int v = 0; v < 60; ++v) {
    for (int u = 0; u < 90; ++u) {
      EXPECT_LE(std::abs(back.data[static_cast<std::size_t>(90 * v + u)] - (2 * u + v)), 4);
    }
  }
}

TEST(EncodeJpeg, TakesMeansOfWholePixelsWhereTheImageIsTooWide) {
  const GreyPixels back = decoded(encode_jpeg(Slope().view(), 95, 40));  // every third
  ASSERT_EQ(back.width, 30);
  ASSERT_EQ(back.height, 20);
  EXPECT_NEAR(back.data[10 * 30 + 15], 2 * 46 + 31, 4);
}

TEST(EncodeJpeg, RefusesAnEmptyImage) { EXPECT_THROW((void)encode_jpeg({}, 80, 100), std::invalid_argument); }

}  // namespace
}  // namespace limber
