// SPDX-License-Identifier: MIT
#include "limber/frontend/decode_image.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "limber/core/errors.hpp"
#include "message_of.hpp"

namespace limber {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::message_of;

EncodedImage image(const std::string& encoding, int width, int height, std::vector<std::uint8_t> data) {
  EncodedImage out;
  out.encoding = encoding;
  out.width = width;
  out.height = height;
  out.step = data.size() / static_cast<std::size_t>(height);
  out.data = std::move(data);
  return out;
}

TEST(DecodeGrey, KeepsGreyPixelsAndLeavesThePaddingOfRowsOut) {
  EXPECT_THAT(decode_grey(image("mono8", 2, 2, {1, 2, 99, 3, 4, 99}), "x").data, ElementsAre(1, 2, 3, 4));
}

TEST(DecodeGrey, KeepsTheHighestEightBitsThatAreUsed) {
  EncodedImage twelve = image("mono16", 3, 1, {0x0f, 0x00, 0xff, 0x0f, 0x10, 0x08});
  twelve.bits = 12;
  EXPECT_THAT(decode_grey(twelve, "x").data, ElementsAre(0, 255, 0x81));
  EncodedImage big = image("mono16", 2, 1, {0x12, 0xff, 0xfe, 0x00});
  big.big_endian = true;
  EXPECT_THAT(decode_grey(big, "x").data, ElementsAre(0x12, 0xfe));
}

TEST(DecodeGrey, WeighsColoursByTheirOrder) {
  const auto red_first = decode_grey(image("rgb8", 1, 1, {200, 0, 0}), "x").data;
  const auto red_last = decode_grey(image("bgr8", 1, 1, {0, 0, 200}), "x").data;
  EXPECT_EQ(red_first, red_last);
  EXPECT_NEAR(red_first[0], 60, 1);
  EXPECT_EQ(decode_grey(image("bgra8", 1, 1, {0, 0, 200, 9}), "x").data, red_first);
  EXPECT_THAT(decode_grey(image("yuv422", 2, 1, {128, 7, 128, 8}), "x").data, ElementsAre(7, 8));
  EXPECT_THAT(decode_grey(image("yuv422_yuy2", 2, 1, {7, 128, 8, 128}), "x").data, ElementsAre(7, 8));
}

// A scene of one colour, through each pattern: the grey of that colour, away from the border.
TEST(DecodeGrey, KnowsWhereAPatternHasItsColours) {
  constexpr int kSide = 8;
  const std::string patterns[] = {"rggb", "bggr", "gbrg", "grbg"};
  for (const std::string& pattern : patterns) {
    std::vector<std::uint8_t> mosaic;
    for (int v = 0; v < kSide; ++v) {
      for (int u = 0; u < kSide; ++u) {
        mosaic.push_back(pattern[static_cast<std::size_t>(2 * (v % 2) + u % 2)] == 'r' ? 200 : 0);
      }
    }
    const auto grey = decode_grey(image("bayer_" + pattern + "8", kSide, kSide, mosaic), "x");
    EXPECT_NEAR(grey.data[3 * kSide + 3], 60, 1) << pattern;
    EXPECT_NEAR(grey.data[4 * kSide + 4], 60, 1) << pattern;
  }
}

TEST(DecodeGrey, RefusesWhatItDoesNotKnowAndWhatIsTooShort) {
  const auto refused = [](const EncodedImage& of) {
    return message_of<DataError>([&] { (void)decode_grey(of, "FILE, topic /t"); });
  };
  EXPECT_THAT(refused(image("32FC1", 1, 1, {0, 0, 0, 0})), HasSubstr("FILE, topic /t: expected an image of"));
  EncodedImage cut = image("mono8", 4, 4, std::vector<std::uint8_t>(16));
  cut.data.resize(15);
  EXPECT_THAT(refused(cut), HasSubstr("15 bytes"));
  EncodedImage narrow = image("bgr8", 4, 4, std::vector<std::uint8_t>(16));
  EXPECT_THAT(refused(narrow), HasSubstr("rows of 4"));
  EncodedImage nothing = image("mono8", 1, 1, {0});
  nothing.step = 0;
  EXPECT_THAT(refused(nothing), HasSubstr("rows of 0"));
  EncodedImage file;
  file.data = {'h', 'i'};
  EXPECT_THAT(refused(file), HasSubstr("PNG or JPEG"));
}

TEST(EncodePng, LosesNothing) {
  std::vector<std::uint8_t> pixels;
  for (int k = 0; k < 64 * 48; ++k) {
    pixels.push_back(static_cast<std::uint8_t>(k * 37 >> 2));
  }
  EncodedImage file;
  file.data = encode_png(image("mono8", 64, 48, pixels), "x");
  EXPECT_EQ(size_of(file, "x"), std::pair(64, 48));
  EXPECT_EQ(decode_grey(file, "x").data, pixels);
  EXPECT_THROW((void)encode_png(image("yuyv", 2, 1, {1, 2, 3, 4}), "x"), DataError);
}

}  // namespace
}  // namespace limber
