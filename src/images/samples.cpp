// SPDX-License-Identifier: MIT
#include "images/samples.hpp"

#include <cstring>
#include <stdexcept>
#include <string>

namespace limber::images {
namespace {

template <class Sample>
void weigh(const Picture& colour, Picture& grey) {
  constexpr std::uint32_t kRed = 4899, kGreen = 9617, kBlue = 1868, kHalf = 1 << 13;  // sum: 2^14
  const std::size_t pixels = grey.data.size() / sizeof(Sample);
  for (std::size_t k = 0; k < pixels; ++k) {
    Sample rgb[3];
    std::memcpy(rgb, colour.data.data() + k * sizeof rgb, sizeof rgb);
    const auto value = static_cast<Sample>((kRed * rgb[0] + kGreen * rgb[1] + kBlue * rgb[2] + kHalf) >> 14U);
    std::memcpy(grey.data.data() + k * sizeof value, &value, sizeof value);
  }
}

}  // namespace

Picture blank(int width, int height, int channels, int bits) {
  constexpr std::int64_t kMostPixels = 1 << 28;
  if (width <= 0 || height <= 0 || static_cast<std::int64_t>(width) * height > kMostPixels) {
    throw std::runtime_error("an image of " + std::to_string(width) + " x " + std::to_string(height) +
                             " px, where 2^28 pixels are the most");
  }
  Picture picture{width, height, channels, bits, {}};
  picture.data.resize(picture.stride() * static_cast<std::size_t>(height));
  return picture;
}

Picture first_channels(const Picture& picture, int channels) {
  Picture out = blank(picture.width, picture.height, channels, picture.bits);
  const auto from = static_cast<std::size_t>(picture.channels * picture.bits / 8);
  const auto to = static_cast<std::size_t>(channels * picture.bits / 8);
  for (std::size_t k = 0; k * to < out.data.size(); ++k) {
    std::memcpy(out.data.data() + k * to, picture.data.data() + k * from, to);
  }
  return out;
}

Picture grey_of(const Picture& colour) {
  Picture grey = blank(colour.width, colour.height, 1, colour.bits);
  colour.bits == 8 ? weigh<std::uint8_t>(colour, grey) : weigh<std::uint16_t>(colour, grey);
  return grey;
}

}  // namespace limber::images
