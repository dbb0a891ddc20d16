// SPDX-License-Identifier: MIT
#include "decompress.hpp"

#include <bzlib.h>
#include <fmt/format.h>
#include <lz4frame.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <memory>

namespace limber::detail {
namespace {

constexpr std::uint64_t kFirstRoom = std::uint64_t{1} << 22;  // [bytes]

/// What a decompressor did: bytes it took and gave, and whether it saw the end.
struct Progress {
  std::size_t taken = 0, given = 0;
  bool ended = false;
};

/// Calls `step(input, output)` until the end, in room that doubles as it fills.
template <typename Step>
std::vector<std::uint8_t> stream(Bytes content, std::uint64_t size, Step step) {
  if (size > kLargestPiece) {
    throw Damage(fmt::format("a chunk of {} bytes", size));
  }
  std::vector<std::uint8_t> out(std::min(size, kFirstRoom) + 1);  // one too many: to see what runs over
  std::size_t filled = 0;
  while (true) {
    const Progress progress = step(content, std::span(out).subspan(filled));
    content = content.subspan(progress.taken);
    filled += progress.given;
    if (filled > size) {
      throw Damage(fmt::format("a chunk that holds more than its {} bytes", size));
    }
    if (progress.ended) {
      break;
    }
    if (filled == out.size()) {
      out.resize(std::min<std::uint64_t>(size, 2 * out.size()) + 1);
    } else if (progress.taken == 0 && progress.given == 0) {
      throw Damage("a compressed chunk that ends too early");
    }
  }
  if (filled != size) {
    throw Damage(fmt::format("a chunk of {} bytes instead of {}", filled, size));
  }
  out.resize(filled);
  return out;
}

std::vector<std::uint8_t> from_bz2(Bytes content, std::uint64_t size) {
  bz_stream state{};
  if (BZ2_bzDecompressInit(&state, 0, 0) != BZ_OK) {
    throw std::bad_alloc();
  }
  const std::unique_ptr<bz_stream, int (*)(bz_stream*)> owner(&state, BZ2_bzDecompressEnd);
  return stream(content, size, [&](Bytes in, std::span<std::uint8_t> out) {
    state.next_in = reinterpret_cast<char*>(const_cast<std::uint8_t*>(in.data()));
    state.avail_in = static_cast<unsigned>(in.size());
    state.next_out = reinterpret_cast<char*>(out.data());
    state.avail_out = static_cast<unsigned>(out.size());
    const int code = BZ2_bzDecompress(&state);
    if (code != BZ_OK && code != BZ_STREAM_END) {
      throw Damage("broken bz2");
    }
    return Progress{in.size() - state.avail_in, out.size() - state.avail_out, code == BZ_STREAM_END};
  });
}

std::vector<std::uint8_t> from_lz4(Bytes content, std::uint64_t size) {
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION)) != 0) {
    throw std::bad_alloc();
  }
  const std::unique_ptr<LZ4F_dctx, LZ4F_errorCode_t (*)(LZ4F_dctx*)> owner(context,
                                                                           LZ4F_freeDecompressionContext);
  return stream(content, size, [&](Bytes in, std::span<std::uint8_t> out) {
    std::size_t taken = in.size(), given = out.size();
    const std::size_t code = LZ4F_decompress(context, out.data(), &given, in.data(), &taken, nullptr);
    if (LZ4F_isError(code) != 0) {
      throw Damage(std::string("broken lz4: ") + LZ4F_getErrorName(code));
    }
    return Progress{taken, given, code == 0};
  });
}

std::vector<std::uint8_t> from_zstd(Bytes content, std::uint64_t size) {
  const std::unique_ptr<ZSTD_DCtx, std::size_t (*)(ZSTD_DCtx*)> context(ZSTD_createDCtx(), ZSTD_freeDCtx);
  if (!context) {
    throw std::bad_alloc();
  }
  return stream(content, size, [&](Bytes in, std::span<std::uint8_t> out) {
    ZSTD_inBuffer input{in.data(), in.size(), 0};
    ZSTD_outBuffer output{out.data(), out.size(), 0};
    const std::size_t code = ZSTD_decompressStream(context.get(), &output, &input);
    if (ZSTD_isError(code) != 0) {
      throw Damage(std::string("broken zstd: ") + ZSTD_getErrorName(code));
    }
    return Progress{input.pos, output.pos, code == 0 && input.pos == input.size};
  });
}

}  // namespace

std::vector<std::uint8_t> decompress(std::string_view method, Bytes content, std::uint64_t size) {
  if (size == 0) {
    return {};
  }
  if (method == "bz2") {
    return from_bz2(content, size);
  }
  if (method == "lz4") {
    return from_lz4(content, size);
  }
  if (method == "zstd") {
    return from_zstd(content, size);
  }
  throw Damage(
      fmt::format("the compression '{}', which is neither bz2 nor lz4 nor zstd", method.substr(0, 20)));
}

std::uint32_t crc32_of(Bytes content, std::uint32_t start) {
  return static_cast<std::uint32_t>(crc32_z(start, content.data(), content.size()));
}

}  // namespace limber::detail
