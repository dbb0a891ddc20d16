// SPDX-License-Identifier: MIT
#include "images/plain_png.hpp"

#include <gtest/gtest.h>
#include <zlib.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <string>

namespace limber::images {
namespace {

using Random = std::mt19937;

std::string big_endian(std::uint32_t value) {
  std::string out;
  for (int shift = 24; shift >= 0; shift -= 8)
    out += static_cast<char>(value >> static_cast<unsigned>(shift));
  return out;
}

std::string chunk(const std::string& type, const std::string& data) {
  const std::string checked = type + data;
  const auto crc =
      crc32(0, reinterpret_cast<const Bytef*>(checked.data()), static_cast<uInt>(checked.size()));
  return big_endian(static_cast<std::uint32_t>(data.size())) + checked +
         big_endian(static_cast<std::uint32_t>(crc));
}

std::string compressed(const std::string& rows) {
  uLongf size = compressBound(rows.size());
  std::string out(size, '\0');
  compress(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(rows.data()),
           rows.size());
  out.resize(size);
  return out;
}

struct Kind {
  int width, height, bits, colour;
  char interlaced = 0;
};

std::string header_of(const Kind& kind) {
  return big_endian(static_cast<std::uint32_t>(kind.width)) +
         big_endian(static_cast<std::uint32_t>(kind.height)) + static_cast<char>(kind.bits) +
         static_cast<char>(kind.colour) + std::string(2, '\0') + kind.interlaced;
}

/// Rows of bytes that are small mostly, each with a filter of its own.
std::string random_rows(const Kind& kind, Random& random) {
  constexpr int kChannels[] = {1, 0, 3, 1, 2, 0, 4};
  const int row = (kind.width * kind.bits * kChannels[kind.colour] + 7) / 8;
  std::string out;
  for (int v = 0; v < kind.height; ++v) {
    out += static_cast<char>(random() % 5);
    for (int k = 0; k < row; ++k) out += static_cast<char>(random() % 3 == 0 ? random() : random() % 8);
  }
  return out;
}

const std::string kSignature = "\x89PNG\r\n\x1a\n";

std::string file_of(const Kind& kind, Random& random) {
  const std::string pixels = compressed(random_rows(kind, random));
  const std::size_t half = pixels.size() / 2;
  return kSignature + chunk("IHDR", header_of(kind)) + chunk("tEXt", "of a test") +
         chunk("IDAT", pixels.substr(0, half)) + chunk("IDAT", pixels.substr(half)) + chunk("IEND", "");
}

cv::Mat read_by_opencv(const std::string& file) {
  const std::vector<unsigned char> bytes(file.begin(), file.end());
  cv::Mat out = cv::imdecode(bytes, cv::IMREAD_ANYCOLOR | cv::IMREAD_ANYDEPTH);
  if (out.channels() == 3) cv::cvtColor(out, out, cv::COLOR_BGR2RGB);
  return out;
}

bool is_that_of_opencv(const Picture& picture, const std::string& file) {
  const cv::Mat expected = read_by_opencv(file);
  const int depth = picture.bits == 16 ? CV_16U : CV_8U;
  const cv::Mat found(picture.height, picture.width, CV_MAKETYPE(depth, picture.channels),
                      const_cast<std::uint8_t*>(picture.data.data()));
  return expected.type() == found.type() && expected.size() == found.size() &&
         cv::norm(expected, found, cv::NORM_INF) == 0.0;
}

TEST(PlainPng, HasThePixelsThatLibpngReadsWhateverTheFilters) {
  Random random(3);
  for (const int bits : {8, 16}) {
    for (const int colour : {0, 2}) {
      for (const auto& [width, height] : {std::pair(1, 1), std::pair(61, 40), std::pair(7, 200)}) {
        const std::string file = file_of({width, height, bits, colour}, random);
        const std::optional<Picture> picture = decode_plain_png(file);
        ASSERT_TRUE(picture);
        EXPECT_TRUE(is_that_of_opencv(*picture, file)) << bits << " " << colour << " " << width;
      }
    }
  }
}

TEST(PlainPng, IsNoOtherKind) {
  Random random(4);
  EXPECT_FALSE(decode_plain_png(file_of({9, 9, 4, 0}, random)));
  EXPECT_FALSE(decode_plain_png(file_of({9, 9, 8, 4}, random))) << "alpha";
  EXPECT_FALSE(decode_plain_png(file_of({9, 9, 8, 6}, random))) << "alpha";
  EXPECT_FALSE(decode_plain_png(file_of({9, 9, 8, 3}, random))) << "palette";
  EXPECT_FALSE(decode_plain_png(file_of({9, 9, 8, 0, 1}, random))) << "interlaced";
}

TEST(PlainPng, IsWholeAndNothingBeside) {
  Random random(5);
  const Kind kind{20, 10, 8, 0};
  const std::string rows = random_rows(kind, random), header = chunk("IHDR", header_of(kind)),
                    end = chunk("IEND", "");
  const auto reads = [&](const std::string& chunks) {
    return decode_plain_png(kSignature + chunks).has_value();
  };
  const std::string pixels = chunk("IDAT", compressed(rows));
  EXPECT_TRUE(reads(header + pixels + end));
  EXPECT_FALSE(reads(header + pixels)) << "cut off";
  EXPECT_FALSE(reads(header + end)) << "no pixels";
  EXPECT_FALSE(reads(pixels + end)) << "no header";
  EXPECT_FALSE(reads(header + header + pixels + end));
  EXPECT_FALSE(reads(header + pixels + chunk("tEXt", "x") + pixels + end));
  EXPECT_FALSE(reads(header + chunk("ABCD", "") + pixels + end)) << "what must be understood";
  EXPECT_FALSE(reads(header + chunk("IDAT", compressed(rows.substr(1))) + end)) << "a byte too few";
  EXPECT_FALSE(reads(header + chunk("IDAT", compressed(rows + 'x')) + end)) << "a byte too many";
  EXPECT_FALSE(reads(header + chunk("IDAT", compressed(rows) + 'x') + end)) << "and behind the pixels";
  EXPECT_FALSE(reads(header + chunk("IDAT", compressed('\x05' + rows.substr(1))) + end)) << "no such filter";
  EXPECT_FALSE(reads(chunk("IHDR", header_of({30000, 30000, 8, 0})) + pixels + end))
      << "more than it can hold";
}

/// What is damaged is left to libpng; what is not is read as it reads it.
TEST(PlainPng, OfFlippedBytesIsThatOfLibpngOrNone) {
  Random random(6);
  int refused = 0;
  for (int trial = 0; trial < 600; ++trial) {
    std::string file = file_of({31, 20, trial % 2 == 0 ? 8 : 16, 2 * (trial / 2 % 2)}, random);
    file[kSignature.size() + random() % (file.size() - kSignature.size())] = static_cast<char>(random());
    const std::optional<Picture> picture = decode_plain_png(file);
    EXPECT_TRUE(!picture || is_that_of_opencv(*picture, file)) << trial;
    refused += !picture;
  }
  EXPECT_GT(refused, 500);
}

}  // namespace
}  // namespace limber::images
