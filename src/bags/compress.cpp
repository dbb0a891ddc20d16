// SPDX-License-Identifier: MIT
#include "compress.hpp"

#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include <stdexcept>

namespace limber::detail {
namespace {

std::string to_bz2(const std::string& content) {
  constexpr int kBlock = 9, kQuiet = 0, kUsualEffort = 0;
  std::string out(content.size() + content.size() / 100 + 600, '\0');  // as bzlib's manual asks
  auto size = static_cast<unsigned>(out.size());
  const int code =
      BZ2_bzBuffToBuffCompress(out.data(), &size, const_cast<char*>(content.data()),
                               static_cast<unsigned>(content.size()), kBlock, kQuiet, kUsualEffort);
  if (code != BZ_OK) {
    throw std::runtime_error("bz2: error " + std::to_string(code));
  }
  out.resize(size);
  return out;
}

std::string to_lz4(const std::string& content) {
  LZ4F_preferences_t preferences{};
  preferences.frameInfo.blockSizeID = LZ4F_max1MB;
  preferences.frameInfo.blockMode = LZ4F_blockIndependent;
  preferences.frameInfo.contentChecksumFlag = LZ4F_contentChecksumEnabled;
  std::string out(LZ4F_compressFrameBound(content.size(), &preferences), '\0');
  const std::size_t size =
      LZ4F_compressFrame(out.data(), out.size(), content.data(), content.size(), &preferences);
  if (LZ4F_isError(size) != 0) {
    throw std::runtime_error(std::string("lz4: ") + LZ4F_getErrorName(size));
  }
  out.resize(size);
  return out;
}

std::string to_zstd(const std::string& content) {
  std::string out(ZSTD_compressBound(content.size()), '\0');
  const std::size_t size = ZSTD_compress(out.data(), out.size(), content.data(), content.size(), 1);
  if (ZSTD_isError(size) != 0) {
    throw std::runtime_error(std::string("zstd: ") + ZSTD_getErrorName(size));
  }
  out.resize(size);
  return out;
}

}  // namespace

std::string compress(std::string_view method, const std::string& content) {
  return method == "bz2"    ? to_bz2(content)
         : method == "lz4"  ? to_lz4(content)
         : method == "zstd" ? to_zstd(content)
                            : content;
}

}  // namespace limber::detail
