// SPDX-License-Identifier: MIT
// JPEG by libjpeg-turbo.
#include <turbojpeg.h>

#include <memory>
#include <stdexcept>
#include <string>

#include "images/codecs.hpp"
#include "images/samples.hpp"

namespace limber::images {
namespace {

struct Close {
  void operator()(void* handle) const { tjDestroy(handle); }
};
using Handle = std::unique_ptr<void, Close>;

Handle opened(tjhandle made) {
  if (made == nullptr) throw std::bad_alloc();
  return Handle(made);
}

/// Pixels that are missing or made up are only warnings to libjpeg; others (bytes between segments) lose
/// nothing.
bool loses_pixels(const std::string& warning) {
  return warning.find("Corrupt JPEG data") != std::string::npos &&
         warning.find("extraneous bytes") == std::string::npos;
}

void check(int status, const Handle& jpeg) {
  if (status == 0) return;
  const std::string said = tjGetErrorStr2(jpeg.get());
  if (said.find("Premature end") != std::string::npos)
    throw std::runtime_error("a JPEG file that was cut off");
  if (tjGetErrorCode(jpeg.get()) != TJERR_WARNING || loses_pixels(said)) {
    throw std::runtime_error("a JPEG file that cannot be decoded: " + said);
  }
}

}  // namespace

bool is_jpeg(std::string_view file) { return file.starts_with("\xff\xd8\xff"); }

Picture decode_jpeg(std::string_view file, Colours colours) {
  const Handle jpeg = opened(tjInitDecompress());
  const auto* const bytes = reinterpret_cast<const unsigned char*>(file.data());
  int width = 0, height = 0, subsampling = 0, space = 0;
  check(tjDecompressHeader3(jpeg.get(), bytes, file.size(), &width, &height, &subsampling, &space), jpeg);
  const bool grey = colours == Colours::kToGrey || space == TJCS_GRAY;
  Picture picture = blank(width, height, grey ? 1 : 3, 8);
  check(tjDecompress2(jpeg.get(), bytes, file.size(), picture.data.data(), width, 0, height,
                      grey ? TJPF_GRAY : TJPF_RGB, TJFLAG_LIMITSCANS),
        jpeg);
  return picture;
}

}  // namespace limber::images

namespace limber {

std::vector<std::uint8_t> encode_jpeg(const PictureView& picture, int quality) {
  using namespace images;
  if (picture.width <= 0 || picture.height <= 0 || picture.data == nullptr || picture.channels != 1 ||
      picture.bits != 8) {
    throw std::invalid_argument("encode_jpeg: no grey pixels of 8 bits");
  }
  const Handle jpeg = opened(tjInitCompress());
  unsigned long size = tjBufSize(picture.width, picture.height, TJSAMP_GRAY);
  std::vector<std::uint8_t> bytes(size);
  std::uint8_t* out = bytes.data();
  check(tjCompress2(jpeg.get(), picture.data, picture.width, static_cast<int>(picture.stride), picture.height,
                    TJPF_GRAY, &out, &size, TJSAMP_GRAY, quality, TJFLAG_NOREALLOC),
        jpeg);
  bytes.resize(size);
  return bytes;
}

}  // namespace limber
