// SPDX-License-Identifier: MIT
#include "limber/frontend/image_reader.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "datasets/files.hpp"
#include "limber/core/errors.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;

const Camera kCamera{100.0, 100.0, 40.0, 30.0, 80, 60, NoDistortion{}};

class ImageReaderOf : public ::testing::Test {
 protected:
  [[nodiscard]] fs::path write(const std::string& name, const cv::Mat& image) const {
    cv::imwrite((folder() / name).string(), image);
    return folder() / name;
  }

  [[nodiscard]] const fs::path& folder() const { return folder_.path(); }

 private:
  testing::TemporaryFolder folder_;
};

/// Grey values u + v, times `scale`.
cv::Mat slope(int type, int scale) {
  cv::Mat image(kCamera.height, kCamera.width, type);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      if (type == CV_8UC3) {
        image.at<cv::Vec3b>(v, u) = cv::Vec3b::all(static_cast<std::uint8_t>(scale * (u + v)));
      } else if (type == CV_8U) {
        image.at<std::uint8_t>(v, u) = static_cast<std::uint8_t>(scale * (u + v));
      } else {
        image.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(scale * (u + v));
      }
    }
  }
  return image;
}

TEST_F(ImageReaderOf, EveryFormatGivesTheSameGrey) {
  for (const char* name : {"a.png", "a.tif", "a.pgm", "a.jpg"}) {
    const GreyPixels image = ImageReader(kCamera).read(write(name, slope(CV_8U, 1)));
    EXPECT_NEAR(image.data[static_cast<std::size_t>(20 * 80 + 30)], 50, 1) << name;
  }
  for (const char* name : {"c.png", "c.ppm", "c.tif"}) {
    const GreyPixels image = ImageReader(kCamera).read(write(name, slope(CV_8UC3, 1)));
    EXPECT_NEAR(image.data[static_cast<std::size_t>(20 * 80 + 30)], 50, 1) << name;
  }
}

TEST_F(ImageReaderOf, SixteenBitsKeepTheHighestEightInUse) {
  for (const auto& [scale, shift] : {std::pair{1, 0}, {7, 2}, {29, 4}, {110, 6}, {470, 8}}) {
    const GreyPixels image = ImageReader(kCamera).read(write("a.png", slope(CV_16U, scale)));
    EXPECT_EQ(image.data[static_cast<std::size_t>(20 * 80 + 30)], (scale * 50) >> shift) << scale;
  }
}

TEST_F(ImageReaderOf, ADarkImageAfterABrightOneIsDark) {
  ImageReader reader(kCamera);
  (void)reader.read(write("bright.png", slope(CV_16U, 29)));  // 12 bits
  EXPECT_EQ(reader.read(write("dark.png", slope(CV_16U, 1))).data[20 * 80 + 30], 50 >> 4);
}

TEST_F(ImageReaderOf, RefusesWhatIsNoImageOfThisCamera) {
  const fs::path text = folder() / "text.pgm";
  std::ofstream(text) << "P5 eighty 60 255\n";
  EXPECT_THROW((void)ImageReader(kCamera).read(text), DataError);
  const fs::path cut = folder() / "cut.tif";
  std::ofstream(cut) << "II*";
  EXPECT_THROW((void)ImageReader(kCamera).read(cut), DataError);
  const fs::path large = write("large.tif", cv::Mat::zeros(10, 10, CV_8U));
  EXPECT_THROW((void)ImageReader(kCamera).read(large), DataError);
  const fs::path numbers = write("numbers.tif", cv::Mat::zeros(kCamera.height, kCamera.width, CV_32F));
  EXPECT_THROW((void)ImageReader(kCamera).read(numbers), DataError);
}

}  // namespace
}  // namespace limber
