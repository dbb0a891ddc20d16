// SPDX-License-Identifier: MIT
// The specification: www.w3.org/TR/png, chunks in section 5, filters in section 9.
#include "images/plain_png.hpp"

#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include "images/samples.hpp"

namespace limber::images {
namespace {

using Byte = std::uint8_t;

constexpr std::size_t kSignature = 8,
                      kAround = 12;           // bytes before the first chunk; of a chunk beside its data
constexpr std::size_t kMostInflation = 1032;  // of deflate: more pixels than that a file does not hold
enum class Filter : Byte { kNone, kSub, kUp, kAverage, kPaeth };

std::uint32_t big_endian(const char* four) {
  std::uint32_t out = 0;
  for (int k = 0; k < 4; ++k) out = out << 8U | static_cast<Byte>(four[k]);
  return out;
}

/// The next chunk; nothing if what follows is none.
struct Chunk {
  std::string_view type, data;
};

std::optional<Chunk> take_chunk(std::string_view& rest) {
  if (rest.size() < kAround) return std::nullopt;
  const std::size_t size = big_endian(rest.data());
  if (size > rest.size() - kAround) return std::nullopt;
  const std::string_view checked = rest.substr(4, 4 + size);
  if (libdeflate_crc32(0, checked.data(), checked.size()) != big_endian(rest.data() + 8 + size)) {
    return std::nullopt;
  }
  rest.remove_prefix(kAround + size);
  return Chunk{checked.substr(0, 4), checked.substr(4)};
}

struct PlainFile {
  std::string_view header;
  std::string compressed;
};

/// Its chunks, if they are those of a whole file and none is missing that has to be understood.
std::optional<PlainFile> chunks_of(std::string_view file) {
  std::string_view rest = file.substr(std::min(kSignature, file.size()));
  PlainFile out;
  bool ended_pixels = false;
  while (const std::optional<Chunk> chunk = take_chunk(rest)) {
    const bool pixels = chunk->type == "IDAT";
    if ((chunk->type == "IHDR") != out.header.empty() || (pixels && ended_pixels)) return std::nullopt;
    if (chunk->type == "IEND") return out;
    if (chunk->type == "IHDR") {
      out.header = chunk->data;
    } else if (pixels) {
      out.compressed += chunk->data;
    } else if (chunk->type[0] < 'a') {  // a capital: must not be left out
      return std::nullopt;
    } else {
      ended_pixels = !out.compressed.empty();
    }
  }
  return std::nullopt;
}

/// A picture of the header's size; nothing of colours by palette, with alpha, of other bits, interlaced.
std::optional<Picture> blank_of(const PlainFile& file) {
  if (file.header.size() != 13) return std::nullopt;
  const std::uint32_t width = big_endian(file.header.data()), height = big_endian(file.header.data() + 4);
  const char bits = file.header[8], colour = file.header[9];
  const bool plain = (bits == 8 || bits == 16) && (colour == 0 || colour == 2) &&
                     file.header.substr(10) == std::string_view("\0\0\0", 3);
  constexpr std::uint32_t kWidest = 1'000'000;  // of libpng
  if (!plain || width == 0 || height == 0 || width > kWidest || height > kWidest) return std::nullopt;
  const int channels = colour == 0 ? 1 : 3;
  const std::uint64_t bytes = std::uint64_t{width} * height * static_cast<unsigned>(channels * bits / 8);
  if (bytes / kMostInflation > file.compressed.size()) return std::nullopt;
  return blank(static_cast<int>(width), static_cast<int>(height), channels, bits);
}

/// The rows as they are filtered, each behind the number of its filter; nothing if that is not all.
std::optional<std::vector<Byte>> inflated(const std::string& compressed, std::size_t size) {
  const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)> inflate(
      libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
  if (!inflate) throw std::bad_alloc();
  std::vector<Byte> out(size);
  std::size_t taken = 0, given = 0;
  const libdeflate_result result = libdeflate_zlib_decompress_ex(
      inflate.get(), compressed.data(), compressed.size(), out.data(), out.size(), &taken, &given);
  const bool all = result == LIBDEFLATE_SUCCESS && taken == compressed.size() && given == size;
  return all ? std::optional(std::move(out)) : std::nullopt;
}

/// Whichever of left, above and what is between them is next to left + above - between; in this order.
int paeth(int left, int above, int between) {
  const int low = std::min(left, above), high = std::max(left, above);
  const int side = 3 * between - left - above;
  const int unless_low = high <= side ? low : between;
  return side <= low ? high : unless_low;
}

/// Undoes a filter that predicts each byte from those of the pixel on the left and of the row above.
template <std::size_t kPixel, typename Predict>
void add_predicted(const Byte* filtered, const Byte* above, std::size_t size, Byte* row, Predict predict) {
  std::array<int, kPixel> left{}, between{};
  for (std::size_t k = 0; k < size; k += kPixel) {
    for (std::size_t i = 0; i < kPixel; ++i) {
      const int up = above[k + i];
      left[i] = (filtered[k + i] + predict(left[i], up, between[i])) & 0xff;
      row[k + i] = static_cast<Byte>(left[i]);
      between[i] = up;
    }
  }
}

/// @return whether there is such a filter
template <std::size_t kPixel>
bool unfilter(Filter filter, const Byte* filtered, const Byte* above, std::size_t size, Byte* row) {
  const auto add = [&](auto predict) { add_predicted<kPixel>(filtered, above, size, row, predict); };
  switch (filter) {
    case Filter::kNone:
      std::copy_n(filtered, size, row);
      return true;
    case Filter::kSub:
      add([](int left, int, int) { return left; });
      return true;
    case Filter::kUp:
      add([](int, int up, int) { return up; });
      return true;
    case Filter::kAverage:
      add([](int left, int up, int) { return (left + up) / 2; });
      return true;
    case Filter::kPaeth:
      add(paeth);
      return true;
  }
  return false;
}

template <std::size_t kPixel>
bool unfilter_all(const std::vector<Byte>& filtered, Picture& picture) {
  const std::size_t size = picture.stride();
  const std::vector<Byte> nothing(size);
  const Byte* above = nothing.data();
  Byte* row = picture.data.data();
  for (auto from = filtered.data(); from != filtered.data() + filtered.size(); from += size + 1) {
    if (!unfilter<kPixel>(static_cast<Filter>(*from), from + 1, above, size, row)) return false;
    above = row;
    row += size;
  }
  return true;
}

bool unfilter_all(const std::vector<Byte>& filtered, Picture& picture) {
  switch (picture.channels * picture.bits / 8) {
    case 1:
      return unfilter_all<1>(filtered, picture);
    case 2:
      return unfilter_all<2>(filtered, picture);
    case 3:
      return unfilter_all<3>(filtered, picture);
    default:
      return unfilter_all<6>(filtered, picture);
  }
}

/// Samples of 16 bits are big-endian in the file.
void to_native(Picture& picture) {
  if (picture.bits == 8 || std::endian::native == std::endian::big) return;
  for (std::size_t k = 0; k + 1 < picture.data.size(); k += 2) {
    std::swap(picture.data[k], picture.data[k + 1]);
  }
}

}  // namespace

std::optional<Picture> decode_plain_png(std::string_view file) {
  const std::optional<PlainFile> chunks = chunks_of(file);
  std::optional<Picture> picture = chunks ? blank_of(*chunks) : std::nullopt;
  if (!picture) return std::nullopt;
  const std::size_t rows = static_cast<std::size_t>(picture->height);
  const auto filtered = inflated(chunks->compressed, rows * (picture->stride() + 1));
  if (!filtered || !unfilter_all(*filtered, *picture)) return std::nullopt;
  to_native(*picture);
  return picture;
}

}  // namespace limber::images
