// SPDX-License-Identifier: MIT
// PNG: read by libpng, unless it is plain, and written by libspng.
#include <png.h>
#include <spng.h>
#include <zlib.h>

#include <bit>
#include <csetjmp>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

#include "images/codecs.hpp"
#include "images/plain_png.hpp"
#include "images/samples.hpp"

namespace limber::images {
namespace {

using Context = std::unique_ptr<spng_ctx, decltype(&spng_ctx_free)>;

Context context(int flags) {
  Context made(spng_ctx_new(flags), spng_ctx_free);
  if (!made) throw std::bad_alloc();
  return made;
}

void check(int status, const char* doing) {
  if (status != SPNG_OK) {
    throw std::runtime_error(std::string("a PNG file that cannot be ") + doing + ": " +
                             spng_strerror(status));
  }
}

/// The file in memory, as libpng reads it, and what libpng says of it.
struct Source {
  std::string_view rest;
  std::string said;
};

[[noreturn]] void remember(png_structp png, png_const_charp said) {
  static_cast<Source*>(png_get_error_ptr(png))->said = said;
  png_longjmp(png, 1);
}

void ignore(png_structp, png_const_charp) {}

void take(png_structp png, png_bytep to, std::size_t count) {
  std::string_view& rest = static_cast<Source*>(png_get_io_ptr(png))->rest;
  if (rest.size() < count) png_error(png, "cut off");
  std::memcpy(to, rest.data(), count);
  rest.remove_prefix(count);
}

/// libpng leaves its functions by longjmp: those that call it hold nothing that has to be destroyed.
class PngReader {
 public:
  explicit PngReader(std::string_view file) : source_{file, {}} {
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, &source_, remember, ignore);
    info_ = png_ == nullptr ? nullptr : png_create_info_struct(png_);
    if (info_ == nullptr) {
      png_destroy_read_struct(&png_, nullptr, nullptr);
      throw std::bad_alloc();
    }
    png_set_read_fn(png_, &source_, take);
  }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;
  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }

  Picture read() {
    if (!begin()) refuse();
    Picture picture = blank(static_cast<int>(png_get_image_width(png_, info_)),
                            static_cast<int>(png_get_image_height(png_, info_)),
                            png_get_channels(png_, info_), png_get_bit_depth(png_, info_));
    std::vector<png_bytep> rows(static_cast<std::size_t>(picture.height));
    for (std::size_t v = 0; v < rows.size(); ++v) rows[v] = picture.data.data() + v * picture.stride();
    if (!finish(rows.data())) refuse();
    return picture;
  }

 private:
  bool begin() {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_read_info(png_, info_);
    png_set_packing(png_);
    png_set_expand_gray_1_2_4_to_8(png_);
    if (png_get_color_type(png_, info_) == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png_);
    png_set_strip_alpha(png_);
    if (std::endian::native == std::endian::little) png_set_swap(png_);
    png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    return true;
  }

  bool finish(png_bytepp rows) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_read_image(png_, rows);
    png_read_end(png_, nullptr);
    return true;
  }

  [[noreturn]] void refuse() const {
    throw std::runtime_error(source_.said == "cut off"
                                 ? "a PNG file that was cut off"
                                 : "a PNG file that cannot be decoded: " + source_.said);
  }

  Source source_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

}  // namespace

bool is_png(std::string_view file) {
  using namespace std::string_view_literals;
  return file.starts_with("\x89PNG\r\n\x1a\n"sv);
}

Picture decode_png(std::string_view file) {
  std::optional<Picture> plain = decode_plain_png(file);
  return plain ? *std::move(plain) : PngReader(file).read();
}

}  // namespace limber::images

namespace limber {

std::vector<std::uint8_t> encode_png(const PictureView& picture) {
  using namespace images;
  constexpr int kColour[] = {0, SPNG_COLOR_TYPE_GRAYSCALE, SPNG_COLOR_TYPE_GRAYSCALE_ALPHA,
                             SPNG_COLOR_TYPE_TRUECOLOR, SPNG_COLOR_TYPE_TRUECOLOR_ALPHA};
  const bool fits = picture.width > 0 && picture.height > 0 && picture.data != nullptr &&
                    picture.channels >= 1 && picture.channels <= 4 &&
                    (picture.bits == 8 || picture.bits == 16);
  if (!fits) throw std::invalid_argument("encode_png: no pixels of 1 to 4 channels of 8 or 16 bits");
  const Context png = context(SPNG_CTX_ENCODER);
  spng_set_option(png.get(), SPNG_ENCODE_TO_BUFFER, 1);
  // Runs of what differs from the pixel on the left: most of the gain for a fifth of the time.
  spng_set_option(png.get(), SPNG_FILTER_CHOICE, SPNG_FILTER_CHOICE_SUB);
  spng_set_option(png.get(), SPNG_IMG_COMPRESSION_LEVEL, Z_BEST_SPEED);
  spng_set_option(png.get(), SPNG_IMG_COMPRESSION_STRATEGY, Z_RLE);
  spng_ihdr header{};
  header.width = static_cast<std::uint32_t>(picture.width);
  header.height = static_cast<std::uint32_t>(picture.height);
  header.bit_depth = static_cast<std::uint8_t>(picture.bits);
  header.color_type = static_cast<std::uint8_t>(kColour[picture.channels]);
  check(spng_set_ihdr(png.get(), &header), "described");
  check(
      spng_encode_image(png.get(), nullptr, 0, SPNG_FMT_PNG, SPNG_ENCODE_PROGRESSIVE | SPNG_ENCODE_FINALIZE),
      "begun");
  const std::size_t row =
      static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.channels * picture.bits / 8);
  for (int v = 0; v < picture.height; ++v) {
    const int status =
        spng_encode_row(png.get(), picture.data + static_cast<std::size_t>(v) * picture.stride, row);
    if (status != SPNG_EOI) check(status, "encoded");
  }
  std::size_t size = 0;
  int status = SPNG_OK;
  const std::unique_ptr<void, decltype(&std::free)> bytes(spng_get_png_buffer(png.get(), &size, &status),
                                                          std::free);
  check(status, "finished");
  const auto* const first = static_cast<const std::uint8_t*>(bytes.get());
  return {first, first + size};
}

}  // namespace limber
