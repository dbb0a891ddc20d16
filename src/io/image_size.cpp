// SPDX-License-Identifier: MIT
#include "io/image_size.hpp"

#include <array>
#include <cstdint>
#include <fstream>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

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

// "P5" or "P6" (or their text forms), then width and height between blanks and comments.
std::optional<ImageSize> pnm_size(std::istream& stream) {
  if (stream.get() != 'P' || stream.peek() < '2' || stream.peek() > '6' || stream.get() == '4') {
    return std::nullopt;
  }
  const auto number = [&stream]() -> std::optional<std::uint32_t> {
    while (stream >> std::ws && stream.peek() == '#') {
      stream.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
    }
    std::uint32_t value = 0;
    return stream >> value ? std::optional(value) : std::nullopt;
  };
  const auto width = number();
  return size_of(width, number());
}

// Byte order, 42, place of the first directory; its entries of 12 bytes: tag, type, count, value.
std::optional<ImageSize> tiff_size(std::istream& stream) {
  std::array<char, 4> start{};
  stream.read(start.data(), start.size());
  const std::string_view order(start.data(), 4);
  if (!stream || (order != "II*\0"sv && order != "MM\0*"sv)) {
    return std::nullopt;
  }
  const auto number = [&stream, swapped = order[0] == 'I'](int count) -> std::optional<std::uint32_t> {
    const auto value = big_endian(stream, count);
    if (!value || !swapped) return value;
    return count == 2 ? (*value >> 8 | (*value & 0xffU) << 8) : __builtin_bswap32(*value);
  };
  stream.seekg(number(4).value_or(0));
  std::optional<std::uint32_t> width, height;
  for (std::uint32_t entries = number(2).value_or(0); entries > 0 && stream; --entries) {
    const auto tag = number(2), type = number(2), count = number(4);
    const auto value = type == 3U ? number(2) : number(4);
    if (type == 3U) stream.ignore(2);
    if (count == 1U && tag == 256U) width = value;
    if (count == 1U && tag == 257U) height = value;
  }
  return size_of(width, height);
}

}  // namespace

std::optional<ImageSize> image_size_of(std::istream& content) {
  for (const auto reader : {png_size, jpeg_size, pnm_size, tiff_size}) {
    content.clear();
    content.seekg(0);
    if (const auto size = reader(content)) {
      return size;
    }
  }
  return std::nullopt;
}

ImageSize read_image_size(const std::filesystem::path& path) {
  std::ifstream stream;
  if (std::error_code unreadable; std::filesystem::is_regular_file(path, unreadable)) {
    stream.open(path, std::ios::binary);
  }
  if (!stream.is_open()) {
    throw DataError(path.string(), 0, "an image", "no such file, or not readable");
  }
  const auto size = image_size_of(stream);
  if (!size) {
    throw DataError(path.string(), 0, "a PNG, JPEG, TIFF, PGM or PPM image", "another or a damaged header");
  }
  return *size;
}

}  // namespace limber::detail
