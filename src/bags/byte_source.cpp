// SPDX-License-Identifier: MIT
#include "byte_source.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <functional>

#include "limber/core/errors.hpp"

namespace limber::detail {
namespace {

constexpr std::uint64_t kWindow = 16'384;  // [bytes]

void require_within(std::uint64_t at, std::uint64_t count, std::uint64_t size) {
  if (at > size || count > size - at) {
    throw Damage(fmt::format("{} bytes are missing at its end", at > size ? count : count - (size - at)));
  }
  if (count > kLargestPiece) {
    throw Damage(fmt::format("a piece of {} bytes", count));
  }
}

}  // namespace

std::uint64_t find_bytes(ByteSource& bytes, std::uint64_t from, std::uint64_t end, std::string_view pattern) {
  constexpr std::uint64_t kStep = 65'536;
  for (std::uint64_t at = from; at < end && end - at >= pattern.size();) {
    const Bytes part = bytes.view(at, std::min(kStep, end - at));
    const auto found = std::search(part.begin(), part.end(),
                                   std::boyer_moore_horspool_searcher(pattern.begin(), pattern.end()));
    if (found != part.end()) {
      return at + static_cast<std::uint64_t>(found - part.begin());
    }
    at += part.size() - (pattern.size() - 1);  // it may begin in this part and end in the next
  }
  return end;
}

Bytes MemoryBytes::view(std::uint64_t at, std::uint64_t count) {
  require_within(at, count, bytes_.size());
  return bytes_.subspan(at, count);
}

FileBytes::FileBytes(std::filesystem::path path) : path_(std::move(path)) {
  struct stat status {};
  descriptor_ = open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  const bool opened = descriptor_ >= 0 && fstat(descriptor_, &status) == 0;
  if (!opened || !S_ISREG(status.st_mode)) {
    const std::string why = opened ? "something that is no regular file" : std::strerror(errno);
    if (descriptor_ >= 0) {
      close(descriptor_);
    }
    throw DataError(path_.string(), 0, "a readable file", why);
  }
  size_ = static_cast<std::uint64_t>(status.st_size);
}

FileBytes::~FileBytes() { close(descriptor_); }

void FileBytes::read(std::uint64_t at, std::span<std::uint8_t> out) const {
  std::size_t done = 0;
  while (done < out.size()) {
    const ssize_t got =
        pread(descriptor_, out.data() + done, out.size() - done, static_cast<off_t>(at + done));
    if (got < 0 && errno == EINTR) {
      continue;
    }
    if (got <= 0) {
      throw Damage(got < 0 ? std::strerror(errno) : "the file has become shorter");
    }
    done += static_cast<std::size_t>(got);
  }
}

Bytes FileBytes::view(std::uint64_t at, std::uint64_t count) {
  require_within(at, count, size_);
  if (at < window_at_ || at + count > window_at_ + window_.size()) {
    window_.resize(std::min(std::max(count, kWindow), size_ - at));
    window_at_ = at;
    try {
      read(at, window_);
    } catch (...) {
      window_.clear();
      throw;
    }
  }
  return Bytes(window_).subspan(at - window_at_, count);
}

std::vector<std::uint8_t> FileBytes::copy(std::uint64_t at, std::uint64_t count) const {
  std::vector<std::uint8_t> out;
  copy(at, count, out);
  return out;
}

void FileBytes::copy(std::uint64_t at, std::uint64_t count, std::vector<std::uint8_t>& out) const {
  require_within(at, count, size_);
  out.resize(count);
  read(at, out);
}

Bytes FieldReader::take(std::uint64_t count) {
  if (count > bytes_.size() - at_) {
    throw Damage(fmt::format("a field of {} bytes where {} are left", count, bytes_.size() - at_));
  }
  const Bytes out = bytes_.subspan(at_, count);
  at_ += count;
  return out;
}

std::string FieldReader::text() {
  const Bytes bytes = take(integer<std::uint32_t>());
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace limber::detail
