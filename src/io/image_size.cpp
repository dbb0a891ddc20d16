// SPDX-License-Identifier: MIT
#include "io/image_size.hpp"

#include <array>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>

#include "limber/core/errors.hpp"

namespace limber::detail {
namespace {

using namespace std::string_view_literals;

// The next `count` bytes as a big-endian integer; nothing at the end of the file.
std::optional<std::uint32_t> big_endian(std::istream& stream, int count) {
  std::uint32_t value = 0;
  for (int k = 0; k < count; ++k) {
    const int byte = stream.get();
    if (byte == std::istream::traits_type::eof()) {
      return std::nullopt;
    }
    value = value << 8 | static_cast<std::uint32_t>(byte);
  }
  return value;
}

std::optional<ImageSize> size_of(std::optional<std::uint32_t> width, std::optional<std::uint32_t> height) {
  constexpr std::uint32_t kLargest = 100'000;
  if (!width || !height || *width == 0 || *height == 0 || *width > kLargest || *height > kLargest) {
    return std::nullopt;
  }
  return ImageSize{static_cast<int>(*width), static_cast<int>(*height)};
}

// Signature (8 bytes), then the IHDR chunk: length, "IHDR", width, height.
std::optional<ImageSize> png_size(std::istream& stream) {
  std::array<char, 16> start{};
  stream.read(start.data(), start.size());
  if (!stream || std::string_view(start.data(), 8) != "\x89PNG\r\n\x1a\n"sv ||
      std::string_view(start.data() + 12, 4) != "IHDR"sv) {
    return std::nullopt;
  }
  const auto width = big_endian(stream, 4);
  return size_of(width, big_endian(stream, 4));
}

// Walks the segments to the frame header SOF0..SOF15: length, bits, height, width.
std::optional<ImageSize> jpeg_size(std::istream& stream) {
  if (big_endian(stream, 2) != 0xffd8U) {
    return std::nullopt;
  }
  while (const auto marker = big_endian(stream, 2)) {
    const bool frame_header = *marker >= 0xffc0U && *marker <= 0xffcfU && *marker != 0xffc4U &&
                              *marker != 0xffc8U && *marker != 0xffccU;
    const auto length = big_endian(stream, 2);
    if (*marker < 0xff00U || !length || *length < 2) {
      return std::nullopt;
    }
    if (frame_header) {
      stream.ignore(1);
      const auto height = big_endian(stream, 2);
      return size_of(big_endian(stream, 2), height);
    }
    stream.ignore(*length - 2);
  }
  return std::nullopt;
}

}  // namespace

std::optional<ImageSize> image_size_of(std::istream& content) {
  if (const auto size = png_size(content)) {
    return size;
  }
  content.clear();
  content.seekg(0);
  return jpeg_size(content);
}

ImageSize read_image_size(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) {
    throw DataError(path.string(), 0, "an image", "no such file, or not readable");
  }
  const auto size = image_size_of(stream);
  if (!size) {
    throw DataError(path.string(), 0, "a PNG or JPEG image", "another or a damaged header");
  }
  return *size;
}

}  // namespace limber::detail
