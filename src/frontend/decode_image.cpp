// SPDX-License-Identifier: MIT
#include "limber/frontend/decode_image.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <string_view>

#include "frontend/image_file.hpp"
#include "io/image_size.hpp"
#include "limber/core/errors.hpp"
#include "limber/images/picture.hpp"

namespace limber {
namespace {

constexpr int kNone = -1;   // already grey
constexpr int kNoPng = -2;  // PNG has no place for it
constexpr long kMostPixels = 1 << 28;

struct Encoding {
  std::string_view name;
  int type;  ///< of OpenCV
  int to_grey;
  int to_rgb;  ///< as PNG files hold it; kNone: as it is
};

// https://docs.ros.org/en/api/sensor_msgs/html/image__encodings_8h_source.html. OpenCV names Bayer patterns
// by the pixels of the second row, from its second column on.
constexpr std::array<Encoding, 24> kEncodings = {
    {{"mono8", CV_8UC1, kNone, kNone},
     {"8UC1", CV_8UC1, kNone, kNone},
     {"mono16", CV_16UC1, kNone, kNone},
     {"16UC1", CV_16UC1, kNone, kNone},
     {"bgr8", CV_8UC3, cv::COLOR_BGR2GRAY, cv::COLOR_BGR2RGB},
     {"8UC3", CV_8UC3, cv::COLOR_BGR2GRAY, cv::COLOR_BGR2RGB},
     {"rgb8", CV_8UC3, cv::COLOR_RGB2GRAY, kNone},
     {"bgra8", CV_8UC4, cv::COLOR_BGRA2GRAY, cv::COLOR_BGRA2RGBA},
     {"8UC4", CV_8UC4, cv::COLOR_BGRA2GRAY, cv::COLOR_BGRA2RGBA},
     {"rgba8", CV_8UC4, cv::COLOR_RGBA2GRAY, kNone},
     {"bgr16", CV_16UC3, cv::COLOR_BGR2GRAY, cv::COLOR_BGR2RGB},
     {"rgb16", CV_16UC3, cv::COLOR_RGB2GRAY, kNone},
     {"bayer_rggb8", CV_8UC1, cv::COLOR_BayerBG2GRAY, kNone},
     {"bayer_bggr8", CV_8UC1, cv::COLOR_BayerRG2GRAY, kNone},
     {"bayer_gbrg8", CV_8UC1, cv::COLOR_BayerGR2GRAY, kNone},
     {"bayer_grbg8", CV_8UC1, cv::COLOR_BayerGB2GRAY, kNone},
     {"bayer_rggb16", CV_16UC1, cv::COLOR_BayerBG2GRAY, kNone},
     {"bayer_bggr16", CV_16UC1, cv::COLOR_BayerRG2GRAY, kNone},
     {"bayer_gbrg16", CV_16UC1, cv::COLOR_BayerGR2GRAY, kNone},
     {"bayer_grbg16", CV_16UC1, cv::COLOR_BayerGB2GRAY, kNone},
     {"yuv422", CV_8UC2, cv::COLOR_YUV2GRAY_UYVY, kNoPng},
     {"uyvy", CV_8UC2, cv::COLOR_YUV2GRAY_UYVY, kNoPng},
     {"yuv422_yuy2", CV_8UC2, cv::COLOR_YUV2GRAY_YUY2, kNoPng},
     {"yuyv", CV_8UC2, cv::COLOR_YUV2GRAY_YUY2, kNoPng}}};

std::string_view bytes_of(const EncodedImage& image) {
  return {reinterpret_cast<const char*>(image.data.data()), image.data.size()};
}

const Encoding& encoding_of(const EncodedImage& image, const std::string& place) {
  const auto found = std::find_if(kEncodings.begin(), kEncodings.end(),
                                  [&](const Encoding& encoding) { return encoding.name == image.encoding; });
  if (found == kEncodings.end()) {
    throw DataError(place, 0,
                    "an image of encoding mono8, mono16, bgr8, rgb8, bgra8, rgba8, bayer_* or yuv422",
                    "'" + image.encoding.substr(0, 40) + "'");
  }
  return *found;
}

/// The pixels as OpenCV sees them; 16 bits in this machine's order, which may need a copy.
cv::Mat pixels_of(const EncodedImage& image, const Encoding& encoding, const std::string& place) {
  const std::size_t row = static_cast<std::size_t>(image.width) * CV_ELEM_SIZE(encoding.type);
  const bool sane =
      image.width > 0 && image.height > 0 && static_cast<long>(image.width) * image.height <= kMostPixels;
  if (!sane || image.step < row || image.data.size() / image.step < static_cast<std::size_t>(image.height)) {
    throw DataError(
        place, 0,
        "the rows of an image of " + frontend::size_text(image.width, image.height) + " in " + image.encoding,
        std::to_string(image.data.size()) + " bytes, rows of " + std::to_string(image.step));
  }
  const cv::Mat pixels(image.height, image.width, encoding.type, const_cast<std::uint8_t*>(image.data.data()),
                       image.step);
  if (CV_MAT_DEPTH(encoding.type) != CV_16U || !image.big_endian) {
    return pixels;
  }
  cv::Mat swapped = pixels.clone();
  std::uint8_t* const data = swapped.data;
  for (std::size_t k = 0; k + 1 < swapped.total() * swapped.elemSize(); k += 2) {
    std::swap(data[k], data[k + 1]);
  }
  return swapped;
}

GreyPixels copied(const cv::Mat& grey) {
  GreyPixels out{grey.cols, grey.rows, {}};
  out.data.resize(grey.total());
  for (int v = 0; v < grey.rows; ++v) {
    std::memcpy(out.data.data() + static_cast<std::size_t>(v) * grey.cols, grey.ptr(v),
                static_cast<std::size_t>(grey.cols));
  }
  return out;
}

}  // namespace

std::pair<int, int> size_of(const EncodedImage& image, const std::string& place) {
  if (!image.encoding.empty()) {
    return {image.width, image.height};
  }
  std::istringstream content{std::string(bytes_of(image))};
  const auto size = detail::image_size_of(content);
  if (!size) {
    throw DataError(place, 0, "a PNG or JPEG image", "another or a damaged header");
  }
  return {size->width, size->height};
}

GreyPixels decode_grey(const EncodedImage& image, const std::string& place) {
  if (image.encoding.empty()) {
    const auto [width, height] = size_of(image, place);
    return {width, height,
            frontend::highest_eight(
                frontend::picture_of(bytes_of(image), width, height, Colours::kToGrey, place), image.bits)};
  }
  const Encoding& encoding = encoding_of(image, place);
  cv::Mat grey = pixels_of(image, encoding, place);
  try {
    if (encoding.to_grey != kNone) {
      cv::Mat converted;
      cv::cvtColor(grey, converted, encoding.to_grey);
      grey = converted;
    }
    if (grey.depth() == CV_16U) {
      cv::Mat eight;
      // floor(v / 2^(bits - 8)): OpenCV rounds, so half a step is taken off first
      const double scale = 1.0 / static_cast<double>(1 << (image.bits - 8));
      grey.convertTo(eight, CV_8U, scale, image.bits > 8 ? -0.5 + 0.5 * scale : 0.0);
      grey = eight;
    }
  } catch (const cv::Exception& error) {
    throw DataError(place, 0, "an image that OpenCV can turn to grey", error.err);
  }
  return copied(grey);
}

std::vector<std::uint8_t> encode_png(const EncodedImage& image, const std::string& place) {
  const Encoding& encoding = encoding_of(image, place);
  if (encoding.to_rgb == kNoPng) {
    throw DataError(place, 0, "an encoding that a PNG file can hold", "'" + image.encoding + "'");
  }
  cv::Mat pixels = pixels_of(image, encoding, place);
  if (encoding.to_rgb != kNone) {
    cv::Mat rgb;
    cv::cvtColor(pixels, rgb, encoding.to_rgb);
    pixels = rgb;
  }
  return encode_png(PictureView{pixels.cols, pixels.rows, pixels.channels(),
                                pixels.depth() == CV_16U ? 16 : 8, pixels.step, pixels.data});
}

}  // namespace limber
