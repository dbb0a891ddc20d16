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

constexpr std::uint64_t kFirstRoom = std::uint64_t{1} << 25;  // [bytes]

/// What a decompressor did: bytes it took and gave, and whether it saw the end.
struct Progress {
  std::size_t taken = 0, given = 0;
  bool ended = false;
};

/// Calls `step(input, output)` until the end, in room that doubles as it fills.
template <typename Step>
void stream(Bytes content, std::uint64_t size, std::vector<std::uint8_t>& out, Step step) {
  if (size > kLargestPiece) {
    throw Damage(fmt::format("a chunk of {} bytes", size));
  }
  out.resize(std::min(size, kFirstRoom) + 1);  // one too many: to see what runs over
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
}

void from_bz2(Bytes content, std::uint64_t size, std::vector<std::uint8_t>& chunk) {
  bz_stream state{};
  if (BZ2_bzDecompressInit(&state, 0, 0) != BZ_OK) {
    throw std::bad_alloc();
  }
  const std::unique_ptr<bz_stream, int (*)(bz_stream*)> owner(&state, BZ2_bzDecompressEnd);
  stream(content, size, chunk, [&](Bytes in, std::span<std::uint8_t> out) {
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

void from_lz4(Bytes content, std::uint64_t size, std::vector<std::uint8_t>& chunk) {
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION)) != 0) {
    throw std::bad_alloc();
  }
  const std::unique_ptr<LZ4F_dctx, LZ4F_errorCode_t (*)(LZ4F_dctx*)> owner(context,
                                                                           LZ4F_freeDecompressionContext);
  stream(content, size, chunk, [&](Bytes in, std::span<std::uint8_t> out) {
    std::size_t taken = in.size(), given = out.size();
    LZ4F_decompressOptions_t options{};
    options.stableDst = size <= kFirstRoom ? 1 : 0;  // what was written stays in its place
    const std::size_t code = LZ4F_decompress(context, out.data(), &given, in.data(), &taken, &options);
    if (LZ4F_isError(code) != 0) {
      throw Damage(std::string("broken lz4: ") + LZ4F_getErrorName(code));
    }
    return Progress{taken, given, code == 0};
  });
}

void require_zstd(std::size_t code) {
  if (ZSTD_isError(code) != 0) {
    throw Damage(std::string("broken zstd: ") + ZSTD_getErrorName(code));
  }
}

void from_zstd(Bytes content, std::uint64_t size, std::vector<std::uint8_t>& chunk) {
  const std::unique_ptr<ZSTD_DCtx, std::size_t (*)(ZSTD_DCtx*)> context(ZSTD_createDCtx(), ZSTD_freeDCtx);
  if (!context) {
    throw std::bad_alloc();
  }
  stream(content, size, chunk, [&](Bytes in, std::span<std::uint8_t> out) {
    if (out.size() > size) {  // room for all of it: no window between
      const std::size_t given =
          ZSTD_decompressDCtx(context.get(), out.data(), out.size(), in.data(), in.size());
      require_zstd(given);
      return Progress{in.size(), given, true};
    }
    ZSTD_inBuffer input{in.data(), in.size(), 0};
    ZSTD_outBuffer output{out.data(), out.size(), 0};
    const std::size_t code = ZSTD_decompressStream(context.get(), &output, &input);
    require_zstd(code);
    return Progress{input.pos, output.pos, code == 0 && input.pos == input.size};
  });
}

}  // namespace

void decompress(std::string_view method, Bytes content, std::uint64_t size, std::vector<std::uint8_t>& out) {
  if (size == 0) {
    out.clear();
  } else if (method == "bz2") {
    from_bz2(content, size, out);
  } else if (method == "lz4") {
    from_lz4(content, size, out);
  } else if (method == "zstd") {
    from_zstd(content, size, out);
  } else {
    throw Damage(
        fmt::format("the compression '{}', which is neither bz2 nor lz4 nor zstd", method.substr(0, 20)));
  }
}

std::uint32_t crc32_of(Bytes content, std::uint32_t start) {
  return static_cast<std::uint32_t>(crc32_z(start, content.data(), content.size()));
}

}  // namespace limber::detail
