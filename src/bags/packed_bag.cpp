// SPDX-License-Identifier: MIT
#include "packed_bag.hpp"

#include <fmt/format.h>
#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

#include "decompress.hpp"
#include "limber/core/errors.hpp"
#include "limber/io/atomic_file.hpp"

namespace limber::detail {
namespace {

namespace fs = std::filesystem;

/// Hands a packed file out piece by piece, unpacked, until `take` has enough and says so.
/// @throws Damage where the file is damaged
void unpack_file(FileBytes& file, const std::function<bool(Bytes)>& take) {
  constexpr std::uint64_t kStep = 1 << 17;
  const std::unique_ptr<ZSTD_DCtx, std::size_t (*)(ZSTD_DCtx*)> context(ZSTD_createDCtx(), ZSTD_freeDCtx);
  if (!context) {
    throw std::bad_alloc();
  }
  std::vector<std::uint8_t> packed, out(ZSTD_DStreamOutSize());
  std::size_t expected = 0;
  for (std::uint64_t at = 0; at < file.size(); at += packed.size()) {
    file.copy(at, std::min(kStep, file.size() - at), packed);
    ZSTD_inBuffer input{packed.data(), packed.size(), 0};
    bool more = true;
    while (input.pos < input.size || more) {
      ZSTD_outBuffer output{out.data(), out.size(), 0};
      expected = ZSTD_decompressStream(context.get(), &output, &input);
      if (ZSTD_isError(expected) != 0) {
        throw Damage(fmt::format("byte {}: broken zstd: {}", at + input.pos, ZSTD_getErrorName(expected)));
      }
      if (!take(Bytes(out).first(output.pos))) {
        return;
      }
      more = output.pos == output.size;
    }
  }
  if (expected != 0) {
    throw Damage(fmt::format("byte {}: the file ends too early", file.size()));
  }
}

void write_all(int descriptor, Bytes bytes, const fs::path& packed, const fs::path& folder) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) {
      continue;
    }
    if (written <= 0) {
      throw DataError(packed.string(), 0,
                      "room in " + folder.string() + " to unpack it (TMPDIR names another place)",
                      std::strerror(errno));
    }
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

/// A bag in a temporary file, which speaks of the packed one.
class PackedBag final : public BagFile {
 public:
  PackedBag(const fs::path& packed, const OpenBag& open)
      : packed_(packed),
        folder_(fs::temp_directory_path()),
        unpacked_(folder_ / packed.stem(), Temporary::Kind::kFile) {
    unpack();
    bag_ = renaming([&] { return open(unpacked_.path()); });
  }

  void walk(const Wanted& wanted, const Visitor& visitor) override {
    renaming([&] { bag_->walk(wanted, visitor); });
    damages_ = bag_->damages();
    for (std::string& damage : damages_) {
      damage = told_of_packed(damage);
    }
    if (!broken_.empty()) {
      damages_.push_back(broken_);
    }
  }
  [[nodiscard]] std::vector<std::uint8_t> read(const BagPlace& place) override {
    return renaming([&] { return bag_->read(place); });
  }
  [[nodiscard]] const std::vector<BagTopic>& topics() const override { return bag_->topics(); }
  [[nodiscard]] const std::vector<std::string>& damages() const override { return damages_; }
  [[nodiscard]] bool is_whole() const override { return broken_.empty() && bag_->is_whole(); }
  [[nodiscard]] std::string format() const override { return bag_->format() + ", zstd"; }

 private:
  void unpack() {
    FileBytes file(packed_);
    constexpr std::uint64_t kLongestHeader = 18;  // [bytes] of a frame
    const Bytes beginning = file.view(0, std::min(kLongestHeader, file.size()));
    const unsigned long long size = ZSTD_getFrameContentSize(beginning.data(), beginning.size());
    const auto room = fs::space(folder_).available;
    if (size != ZSTD_CONTENTSIZE_UNKNOWN && size != ZSTD_CONTENTSIZE_ERROR && size > room) {
      throw DataError(packed_.string(), 0,
                      fmt::format("{} bytes free in {} to unpack it (TMPDIR names another place)", size,
                                  folder_.string()),
                      fmt::format("{}", room));
    }
    try {
      unpack_file(file, [this](Bytes part) {
        write_all(unpacked_.descriptor(), part, packed_, folder_);
        return true;
      });
    } catch (const Damage& damage) {
      broken_ = fmt::format("{}, {}; what follows is left out", packed_.string(), damage.what());
    }
  }

  /// A text with the name of the packed file in the place of that of the temporary one.
  [[nodiscard]] std::string told_of_packed(std::string text) const {
    const std::string name = unpacked_.path().string();
    for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name)) {
      text.replace(at, name.size(), packed_.string());
    }
    return text;
  }

  /// What `act` returns; errors of the temporary file are those of the packed one.
  template <typename Act>
  auto renaming(const Act& act) const -> decltype(act()) {
    try {
      return act();
    } catch (const DataError& error) {
      if (error.file() != unpacked_.path().string()) {
        throw;
      }
      throw DataError(
          packed_.string(), 0, "a bag that zstd has packed",
          "once unpacked: " + told_of_packed(error.what()) + (broken_.empty() ? "" : "; and " + broken_));
    }
  }

  fs::path packed_, folder_;
  Temporary unpacked_;
  std::string broken_;  ///< where unpacking ended too early; empty: it did not
  std::unique_ptr<BagFile> bag_;
  std::vector<std::string> damages_;
};

class UnpackedMessages final : public BagFile {
 public:
  UnpackedMessages(fs::path path, std::unique_ptr<BagFile> bag)
      : path_(std::move(path)), bag_(std::move(bag)) {
    if (!context_) {
      throw std::bad_alloc();
    }
  }

  void walk(const Wanted& wanted, const Visitor& visitor) override {
    bag_->walk(wanted, [&](const BagMessage& message) {
      const BagTopic& topic = bag_->topics()[message.topic];
      if (topic.serialization != Serialization::kCdr || !is_packed(message.data)) {
        visitor(message);
        return;
      }
      BagMessage out = message;
      std::vector<std::uint8_t> unpacked;
      try {
        const std::vector<std::uint8_t> packed = bag_->read(message.place);
        out.place.packed_size = message.place.size;
        out.place.size = size_of(packed);
        unpack_beginning(packed, std::min(out.place.size, std::uint64_t{wanted(topic)}), unpacked);
        out.data = unpacked;
      } catch (const Damage&) {  // goes on as it is, which no message of ROS looks like
      }
      visitor(out);
    });
  }
  [[nodiscard]] std::vector<std::uint8_t> read(const BagPlace& place) override {
    if (place.packed_size == 0) {
      return bag_->read(place);
    }
    BagPlace inner = place;
    inner.size = place.packed_size;
    try {
      return unpack(bag_->read(inner));
    } catch (const Damage& damage) {
      throw DataError(path_.string(), 0, "a message", damage.what());
    }
  }
  [[nodiscard]] const std::vector<BagTopic>& topics() const override { return bag_->topics(); }
  [[nodiscard]] const std::vector<std::string>& damages() const override { return bag_->damages(); }
  [[nodiscard]] bool is_whole() const override { return bag_->is_whole(); }
  [[nodiscard]] std::string format() const override { return bag_->format(); }

 private:
  static std::uint64_t size_of(Bytes packed) {
    const unsigned long long size = ZSTD_getFrameContentSize(packed.data(), packed.size());
    if (size == ZSTD_CONTENTSIZE_UNKNOWN || size == ZSTD_CONTENTSIZE_ERROR) {
      throw Damage("a compressed message that does not say its size");
    }
    return size;
  }

  static std::vector<std::uint8_t> unpack(Bytes packed) {
    std::vector<std::uint8_t> out;
    decompress("zstd", packed, size_of(packed), out);
    return out;
  }

  /// The first `count` bytes of a message, of which no more is unpacked than the blocks that hold them; of
  /// the others the heads are looked at. @throws Damage
  void unpack_beginning(Bytes packed, std::uint64_t count, std::vector<std::uint8_t>& out) {
    if (size_of(packed) > kLargestWindow) {  // grows with what really comes
      out = unpack(packed);
      out.resize(std::min<std::uint64_t>(count, out.size()));
      return;
    }
    if (ZSTD_findFrameCompressedSize(packed.data(), packed.size()) != packed.size()) {
      throw Damage("a compressed message that ends too early, or too late");
    }
    ZSTD_DCtx_reset(context_.get(), ZSTD_reset_session_only);
    out.resize(count);
    ZSTD_inBuffer input{packed.data(), packed.size(), 0};
    ZSTD_outBuffer output{out.data(), out.size(), 0};
    while (output.pos < output.size) {
      const std::size_t before = output.pos + input.pos;
      const std::size_t code = ZSTD_decompressStream(context_.get(), &output, &input);
      if (ZSTD_isError(code) != 0 || output.pos + input.pos == before) {
        throw Damage("broken zstd");
      }
    }
  }

  static constexpr std::uint64_t kLargestWindow = std::uint64_t{1} << 25;  // [bytes]

  std::unique_ptr<ZSTD_DCtx, std::size_t (*)(ZSTD_DCtx*)> context_{ZSTD_createDCtx(), ZSTD_freeDCtx};
  fs::path path_;
  std::unique_ptr<BagFile> bag_;
};

}  // namespace

bool is_packed(Bytes beginning) {
  constexpr std::array<std::uint8_t, 4> kMagic = {0x28, 0xb5, 0x2f, 0xfd};
  return beginning.size() >= kMagic.size() && std::equal(kMagic.begin(), kMagic.end(), beginning.begin());
}

std::string unpacked_beginning(const fs::path& packed, std::size_t count) {
  std::string out;
  try {
    FileBytes file(packed);
    unpack_file(file, [&](Bytes part) {
      out.append(part.begin(), part.end());
      return out.size() < count;
    });
  } catch (const Damage&) {  // what there is, is the answer
  }
  out.resize(std::min(out.size(), count));
  return out;
}

std::unique_ptr<BagFile> open_packed_bag(const fs::path& packed, const OpenBag& open) {
  return std::make_unique<PackedBag>(packed, open);
}

std::unique_ptr<BagFile> with_messages_unpacked(const fs::path& path, std::unique_ptr<BagFile> bag) {
  return std::make_unique<UnpackedMessages>(path, std::move(bag));
}

}  // namespace limber::detail
