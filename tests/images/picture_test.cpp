// SPDX-License-Identifier: MIT
#include "limber/images/picture.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "limber/core/errors.hpp"
#include "message_of.hpp"

namespace limber {
namespace {

using ::testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

std::string_view text_of(const Bytes& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Blurred noise of this type of OpenCV.
cv::Mat noise(int type) {
  cv::RNG random(7);
  cv::Mat image(37, 53, type);
  random.fill(image, cv::RNG::UNIFORM, 0, CV_MAT_DEPTH(type) == CV_16U ? 65536 : 256);
  cv::GaussianBlur(image, image, {}, 1.5);
  return image;
}

Bytes written_by_opencv(const std::string& ending, const cv::Mat& image,
                        const std::vector<int>& options = {}) {
  Bytes bytes;
  cv::imencode(ending, image, bytes, options);
  return bytes;
}

/// As OpenCV holds it: blue, green, red.
cv::Mat matrix_of(Picture& picture) {
  const cv::Mat pixels(picture.height, picture.width,
                       CV_MAKETYPE(picture.bits == 16 ? CV_16U : CV_8U, picture.channels),
                       picture.data.data());
  cv::Mat out = pixels.clone();
  if (picture.channels == 3) cv::cvtColor(pixels, out, cv::COLOR_RGB2BGR);
  return out;
}

double difference(const cv::Mat& a, const cv::Mat& b) {
  EXPECT_EQ(a.type(), b.type());
  return a.type() == b.type() && a.size() == b.size() ? cv::norm(a, b, cv::NORM_INF) : 1e9;
}

struct Case {
  std::string ending;
  int type;
  std::vector<int> options;
};

class FileOfOpenCv : public ::testing::TestWithParam<Case> {};

TEST_P(FileOfOpenCv, IsReadAsOpenCvReadsIt) {
  const auto& [ending, type, options] = GetParam();
  const Bytes file = written_by_opencv(ending, noise(type), options);
  Picture kept = decode_picture(text_of(file), Colours::kKeep, "x");
  EXPECT_EQ(difference(matrix_of(kept), cv::imdecode(file, cv::IMREAD_ANYCOLOR | cv::IMREAD_ANYDEPTH)), 0.0);
  Picture grey = decode_picture(text_of(file), Colours::kToGrey, "x");
  // OpenCV's own decoders weigh the colours each in its own way, to two of 256 and 257 times that of 65536.
  const double bound = CV_MAT_CN(type) == 1 ? 0.0 : CV_MAT_DEPTH(type) == CV_16U ? 2 * 257.0 : 2.0;
  EXPECT_LE(difference(matrix_of(grey), cv::imdecode(file, cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH)),
            bound);
}

INSTANTIATE_TEST_SUITE_P(
    Formats, FileOfOpenCv,
    ::testing::Values(Case{".png", CV_8UC1, {}}, Case{".png", CV_8UC3, {}}, Case{".png", CV_16UC1, {}},
                      Case{".png", CV_16UC3, {}}, Case{".png", CV_8UC4, {}}, Case{".png", CV_16UC4, {}},
                      Case{".jpg", CV_8UC1, {}}, Case{".jpg", CV_8UC3, {}},
                      Case{".jpg", CV_8UC1, {cv::IMWRITE_JPEG_PROGRESSIVE, 1}}, Case{".tif", CV_8UC1, {}},
                      Case{".tif", CV_8UC3, {}}, Case{".tif", CV_16UC1, {}}, Case{".tif", CV_16UC3, {}},
                      Case{".tif", CV_16UC1, {cv::IMWRITE_TIFF_COMPRESSION, 1}}, Case{".pgm", CV_8UC1, {}},
                      Case{".pgm", CV_16UC1, {}}, Case{".pgm", CV_8UC1, {cv::IMWRITE_PXM_BINARY, 0}},
                      Case{".ppm", CV_8UC3, {}}, Case{".ppm", CV_16UC3, {}},
                      Case{".ppm", CV_8UC3, {cv::IMWRITE_PXM_BINARY, 0}}));

class PngOf : public ::testing::TestWithParam<int> {};

TEST_P(PngOf, IsReadByOpenCvToTheBit) {
  const cv::Mat image = noise(GetParam());
  cv::Mat rgb = image.clone();
  if (image.channels() == 3) cv::cvtColor(image, rgb, cv::COLOR_BGR2RGB);
  if (image.channels() == 4) cv::cvtColor(image, rgb, cv::COLOR_BGRA2RGBA);
  const Bytes file =
      encode_png({rgb.cols, rgb.rows, rgb.channels(), rgb.depth() == CV_16U ? 16 : 8, rgb.step, rgb.data});
  EXPECT_EQ(difference(cv::imdecode(file, cv::IMREAD_UNCHANGED), image), 0.0);
}

INSTANTIATE_TEST_SUITE_P(Pixels, PngOf,
                         ::testing::Values(CV_8UC1, CV_16UC1, CV_8UC3, CV_16UC3, CV_8UC4, CV_16UC4));

TEST(EncodePng, TakesEveryOtherRowOfALargerImage) {
  const cv::Mat image = noise(CV_8UC1);
  const int rows = image.rows / 2;
  const Bytes file = encode_png({image.cols, rows, 1, 8, 2 * image.step, image.data});
  const cv::Mat read = cv::imdecode(file, cv::IMREAD_UNCHANGED);
  ASSERT_EQ(read.rows, rows);
  for (int v = 0; v < rows; ++v) EXPECT_EQ(cv::norm(read.row(v), image.row(2 * v), cv::NORM_INF), 0.0);
}

TEST(EncodePicture, RefusesWhatTheFileCannotHold) {
  const Bytes pixels(300);
  EXPECT_THROW((void)encode_png({10, 10, 5, 8, 50, pixels.data()}), std::invalid_argument);
  EXPECT_THROW((void)encode_png({10, 10, 1, 12, 20, pixels.data()}), std::invalid_argument);
  EXPECT_THROW((void)encode_png({}), std::invalid_argument);
  EXPECT_THROW((void)encode_jpeg({10, 10, 3, 8, 30, pixels.data()}, 90), std::invalid_argument);
}

TEST(DecodePicture, SaysWhatIsWrongWithAFile) {
  const auto said = [](const Bytes& file) {
    return testing::message_of<DataError>(
        [&] { (void)decode_picture(text_of(file), Colours::kKeep, "name"); });
  };
  for (const char* ending : {".png", ".jpg", ".pgm"}) {
    Bytes file = written_by_opencv(ending, noise(CV_8UC1));
    file.resize(file.size() * 2 / 3);
    EXPECT_THAT(said(file), HasSubstr("that was cut off")) << ending;
  }
  Bytes tiff = written_by_opencv(".tif", noise(CV_8UC1));
  tiff.resize(tiff.size() / 2);
  EXPECT_THAT(said(tiff), HasSubstr("a TIFF file that cannot be decoded: "));
  EXPECT_THAT(said(written_by_opencv(".tif", cv::Mat::zeros(9, 9, CV_32F))),
              HasSubstr("other numbers as pixels"));
  EXPECT_THAT(said({'P', '5', '\n', '9', ' ', 'x'}), HasSubstr("without a number where one belongs"));
  EXPECT_THAT(said({'P', '5', '\n', '9', '9', '9', '9', '9', ' ', '9', '9', '9', '9', '9', ' ', '9', '\n'}),
              HasSubstr("99999 x 99999 px"));
  EXPECT_EQ(said({'h', 'a', 'l', 'l', 'o'}),
            "name: expected a PNG, JPEG, TIFF, PGM or PPM image, found another format");
}

TEST(DecodePicture, RefusesAJpegWhosePixelsAreMadeUp) {
  Bytes file = written_by_opencv(".jpg", noise(CV_8UC1));
  for (std::size_t k = file.size() / 2; k + 4 < file.size(); k += 2) {
    file[k] = 0xff;  // nothing but ones, which is no code of Huffman's
    file[k + 1] = 0;
  }
  EXPECT_THROW((void)decode_picture(text_of(file), Colours::kToGrey, "x"), DataError);
  file = written_by_opencv(".jpg", noise(CV_8UC1));
  file.insert(file.end() - 2, 3, 0);  // behind the pixels
  EXPECT_NO_THROW((void)decode_picture(text_of(file), Colours::kToGrey, "x"));
}

/// Any byte of a file may be another one: the answer is an image or a DataError.
TEST(DecodePicture, OutlivesFlippedBytes) {
  cv::RNG random(11);
  int refused = 0;
  for (const char* ending : {".png", ".jpg", ".tif", ".ppm"}) {
    const Bytes whole = written_by_opencv(ending, noise(CV_8UC3));
    for (int trial = 0; trial < 400; ++trial) {
      Bytes file = whole;
      for (int flips = random.uniform(1, 4); flips > 0; --flips) {
        const int most =
            trial % 2 == 0 ? std::min<int>(64, static_cast<int>(file.size())) : static_cast<int>(file.size());
        file[static_cast<std::size_t>(random.uniform(0, most))] =
            static_cast<std::uint8_t>(random.uniform(0, 256));
      }
      try {
        const Picture picture = decode_picture(text_of(file), Colours::kToGrey, "x");
        EXPECT_EQ(picture.data.size(), picture.stride() * static_cast<std::size_t>(picture.height));
      } catch (const DataError&) {
        ++refused;
      }
    }
  }
  EXPECT_GT(refused, 400);
}

}  // namespace
}  // namespace limber
