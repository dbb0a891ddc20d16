// SPDX-License-Identifier: MIT
// TIFF by libtiff: its first picture.
#include <tiffio.h>

#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>

#include "images/codecs.hpp"
#include "images/samples.hpp"

namespace limber::images {
namespace {

/// The file in memory, as libtiff reads it, and what libtiff says of it.
struct Source {
  std::string_view file;
  std::size_t at = 0;
  std::string said;
};

Source& source_of(thandle_t handle) { return *static_cast<Source*>(handle); }

tmsize_t read(thandle_t handle, void* to, tmsize_t count) {
  Source& source = source_of(handle);
  const std::size_t left = source.at < source.file.size() ? source.file.size() - source.at : 0;
  const std::size_t taken = std::min(left, static_cast<std::size_t>(count));
  if (taken > 0) std::memcpy(to, source.file.data() + source.at, taken);
  source.at += taken;
  return static_cast<tmsize_t>(taken);
}

tmsize_t refuse_write(thandle_t, void*, tmsize_t) { return 0; }

toff_t seek(thandle_t handle, toff_t offset, int whence) {
  Source& source = source_of(handle);
  const std::size_t base = whence == SEEK_SET ? 0 : whence == SEEK_CUR ? source.at : source.file.size();
  source.at = base + offset;
  return source.at;
}

int leave_open(thandle_t) { return 0; }

toff_t size(thandle_t handle) { return source_of(handle).file.size(); }

int remember(TIFF*, void* source, const char*, const char* format, std::va_list values) {
  char line[200];
  std::vsnprintf(line, sizeof line, format, values);
  std::string& said = static_cast<Source*>(source)->said;
  if (said.empty()) said = line;
  return 1;
}

int ignore(TIFF*, void*, const char*, const char*, std::va_list) { return 1; }

struct Close {
  void operator()(TIFF* tiff) const { TIFFClose(tiff); }
  void operator()(TIFFOpenOptions* options) const { TIFFOpenOptionsFree(options); }
};
using File = std::unique_ptr<TIFF, Close>;

[[noreturn]] void refuse(const Source& source) {
  throw std::runtime_error("a TIFF file that cannot be decoded" +
                           (source.said.empty() ? "" : ": " + source.said));
}

File open(Source& source) {
  const std::unique_ptr<TIFFOpenOptions, Close> options(TIFFOpenOptionsAlloc());
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), remember, &source);
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), ignore, nullptr);
  TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), tmsize_t{1} << 31);
  File tiff(TIFFClientOpenExt("image", "rm", &source, read, refuse_write, seek, leave_open, size, nullptr,
                              nullptr, options.get()));
  if (!tiff) refuse(source);
  return tiff;
}

std::uint32_t field(const File& tiff, std::uint32_t tag, bool is_long = false) {
  std::uint32_t value = 0;
  std::uint16_t small = 0;
  if (is_long) {
    TIFFGetField(tiff.get(), tag, &value);
  } else {
    TIFFGetFieldDefaulted(tiff.get(), tag, &small);
    value = small;
  }
  return value;
}

/// Rows as they are stored: grey or colour side by side.
Picture read_rows(const File& tiff, Picture picture, const Source& source) {
  if (TIFFScanlineSize(tiff.get()) != static_cast<tmsize_t>(picture.stride())) refuse(source);
  for (int v = 0; v < picture.height; ++v) {
    std::uint8_t* const row = picture.data.data() + static_cast<std::size_t>(v) * picture.stride();
    if (TIFFReadScanline(tiff.get(), row, static_cast<std::uint32_t>(v)) != 1) refuse(source);
  }
  const bool has_alpha = picture.channels % 2 == 0;
  return has_alpha ? first_channels(picture, picture.channels - 1) : picture;
}

/// Palettes, tiles, planes, fewer than eight bits: as libtiff turns them to red, green, blue of eight.
Picture read_converted(const File& tiff, const Picture& size, bool grey, const Source& source) {
  Picture rgba = blank(size.width, size.height, 4, 8);
  if (TIFFReadRGBAImageOriented(
          tiff.get(), static_cast<std::uint32_t>(size.width), static_cast<std::uint32_t>(size.height),
          reinterpret_cast<std::uint32_t*>(rgba.data.data()), ORIENTATION_TOPLEFT, 1) != 1) {
    refuse(source);
  }
  return first_channels(rgba, grey ? 1 : 3);
}

}  // namespace

bool is_tiff(std::string_view file) {
  using namespace std::string_view_literals;
  return file.starts_with("II*\0"sv) || file.starts_with("MM\0*"sv);
}

Picture decode_tiff(std::string_view file) {
  Source source{file, 0, {}};
  const File tiff = open(source);
  const std::uint32_t width = field(tiff, TIFFTAG_IMAGEWIDTH, true),
                      height = field(tiff, TIFFTAG_IMAGELENGTH, true);
  const std::uint32_t bits = field(tiff, TIFFTAG_BITSPERSAMPLE),
                      channels = field(tiff, TIFFTAG_SAMPLESPERPIXEL);
  const std::uint32_t meaning = field(tiff, TIFFTAG_PHOTOMETRIC), kind = field(tiff, TIFFTAG_SAMPLEFORMAT);
  if (bits > 16 || (kind != SAMPLEFORMAT_UINT && kind != SAMPLEFORMAT_VOID)) {
    throw std::runtime_error("other numbers as pixels");
  }
  const bool plain = (bits == 8 || bits == 16) &&
                     (meaning == PHOTOMETRIC_MINISBLACK || meaning == PHOTOMETRIC_RGB) && channels >= 1 &&
                     channels <= 4 && TIFFIsTiled(tiff.get()) == 0 &&
                     (channels == 1 || field(tiff, TIFFTAG_PLANARCONFIG) == PLANARCONFIG_CONTIG);
  if (plain) {
    return read_rows(tiff,
                     blank(static_cast<int>(width), static_cast<int>(height), static_cast<int>(channels),
                           static_cast<int>(bits)),
                     source);
  }
  if (bits == 16) throw std::runtime_error("a TIFF file of 16 bits in tiles, planes or inverted");
  const bool grey = meaning == PHOTOMETRIC_MINISBLACK || meaning == PHOTOMETRIC_MINISWHITE;
  Picture size;
  size.width = static_cast<int>(width);
  size.height = static_cast<int>(height);
  return read_converted(tiff, size, grey, source);
}

}  // namespace limber::images
