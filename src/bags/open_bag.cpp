// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <optional>

#include "io/numbers.hpp"
#include "limber/bags/bag_file.hpp"
#include "limber/core/errors.hpp"
#include "mcap_records.hpp"
#include "openers.hpp"
#include "packed_bag.hpp"
#include "ros1_records.hpp"
#include "ros2_folder.hpp"

namespace limber {
namespace detail {

std::string without_msg(std::string type) {
  if (const std::size_t at = type.find("/msg/"); at != std::string::npos) {
    type.erase(at, 4);
  }
  return type;
}

Serialization serialization_from(const std::string& name) {
  return name == "ros1" ? Serialization::kRos1 : name == "cdr" ? Serialization::kCdr : Serialization::kOther;
}

namespace {

namespace fs = std::filesystem;
using namespace std::string_view_literals;

struct Format {
  std::string_view magic;
  std::unique_ptr<BagFile> (*open)(const fs::path&);
  bool rosbag2;  ///< writes it, and may have packed each message
};
constexpr std::array<Format, 3> kFormats = {{{ros1::kMagic, open_ros1_bag, false},
                                             {mcap::kMagic, open_mcap, true},
                                             {"SQLite format 3\0"sv, open_sqlite_bag, true}}};
constexpr std::size_t kBeginning = 16;  // [bytes]

std::string beginning_of(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) {
    return {};
  }
  std::ifstream stream(path, std::ios::binary);
  std::string out(kBeginning, '\0');
  stream.read(out.data(), static_cast<std::streamsize>(out.size()));
  out.resize(static_cast<std::size_t>(stream.gcount()));
  return out;
}

const Format* format_of(const std::string& beginning) {
  const auto found = std::find_if(kFormats.begin(), kFormats.end(),
                                  [&](const Format& format) { return beginning.starts_with(format.magic); });
  return found == kFormats.end() ? nullptr : &*found;
}

Bytes bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

std::unique_ptr<BagFile> open_file(const fs::path& path) {
  const std::string found = beginning_of(path);
  if (const Format* format = format_of(found)) {
    return format->rosbag2 ? with_messages_unpacked(path, format->open(path)) : format->open(path);
  }
  if (is_packed(bytes_of(found)) && format_of(unpacked_beginning(path, kBeginning)) != nullptr) {
    return open_packed_bag(path, open_file);
  }
  if (found.starts_with("#ROSBAG V")) {
    throw DataError(path.string(), 0, "a ROS 1 bag of version 2.0",
                    excerpt(found.substr(0, found.find('\n'))) + ": 'rosbag fix' brings it up to date");
  }
  throw DataError(path.string(), 0, "a ROS 1 bag (.bag), an MCAP file or a ROS 2 bag (.db3)",
                  found.empty() ? "an empty file, or none" : "a file that begins with " + excerpt(found));
}

/// The files of a ROS 2 bag one after another.
class SeveralBags final : public BagFile {
 public:
  /// A file that cannot be read at all is left out. @throws DataError if that is true of each
  explicit SeveralBags(const Ros2Folder& folder) : missing_(folder.missing), remarks_(folder.remarks) {
    for (const fs::path& path : folder.files) {
      try {
        bags_.push_back(open_file(path));
      } catch (const DataError& error) {
        if (bags_.empty() && path == folder.files.back()) {
          throw;
        }
        missing_.push_back(fmt::format("{}; the file is left out", error.what()));
      }
    }
  }

  void walk(const Wanted& wanted, const Visitor& visitor) override {
    topics_.clear();
    damages_ = missing_;
    damages_.insert(damages_.end(), remarks_.begin(), remarks_.end());
    for (std::uint32_t k = 0; k < bags_.size(); ++k) {
      std::vector<std::size_t> indices;  // of this file's topics among all
      bags_[k]->walk(wanted, [&](const BagMessage& message) {
        while (indices.size() <= message.topic) {
          indices.push_back(index_of(bags_[k]->topics()[indices.size()]));
        }
        BagMessage out = message;
        out.topic = indices[message.topic];
        out.place.file = k;
        visitor(out);
      });
      for (const BagTopic& topic : bags_[k]->topics()) {
        (void)index_of(topic);
      }
      const auto& damages = bags_[k]->damages();
      damages_.insert(damages_.end(), damages.begin(), damages.end());
    }
  }
  [[nodiscard]] std::vector<std::uint8_t> read(const BagPlace& place) override {
    return bags_.at(place.file)->read(place);
  }
  [[nodiscard]] const std::vector<BagTopic>& topics() const override { return topics_; }
  [[nodiscard]] const std::vector<std::string>& damages() const override { return damages_; }
  [[nodiscard]] bool is_whole() const override {
    return missing_.empty() &&
           std::all_of(bags_.begin(), bags_.end(), [](const auto& bag) { return bag->is_whole(); });
  }
  [[nodiscard]] std::string format() const override {
    return fmt::format("{} of {} file{}", bags_.front()->format(), bags_.size(),
                       bags_.size() == 1 ? "" : "s");
  }

 private:
  std::size_t index_of(const BagTopic& topic) {
    const auto same = std::find_if(topics_.begin(), topics_.end(), [&](const BagTopic& other) {
      return other.name == topic.name && other.type == topic.type;
    });
    if (same != topics_.end()) {
      return static_cast<std::size_t>(same - topics_.begin());
    }
    topics_.push_back(topic);
    return topics_.size() - 1;
  }

  std::vector<std::string> missing_, remarks_;
  std::vector<std::unique_ptr<BagFile>> bags_;
  std::vector<BagTopic> topics_;
  std::vector<std::string> damages_;
};

}  // namespace

bool begins_like_bag(const fs::path& path) {
  const std::string beginning = beginning_of(path);
  return format_of(beginning) != nullptr ||
         (is_packed(bytes_of(beginning)) && format_of(unpacked_beginning(path, kBeginning)) != nullptr);
}

}  // namespace detail

bool is_bag(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_directory(path, error)) {
    return detail::begins_like_bag(path);
  }
  // An EuRoC folder stays one when somebody puts its bag beside it.
  return !std::filesystem::exists(path / "mav0", error) && detail::is_ros2_folder(path);
}

std::unique_ptr<BagFile> open_bag(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_directory(path, error)) {
    return detail::open_file(path);
  }
  const detail::Ros2Folder folder = detail::ros2_folder(path);
  if (folder.files.empty()) {
    throw DataError(
        path.string(), 0, "the folder of a ROS 2 bag, with .db3 or .mcap files",
        folder.missing.empty() ? "none of them" : fmt::format("{}", fmt::join(folder.missing, "; ")));
  }
  if (folder.files.size() == 1 && folder.missing.empty() && folder.remarks.empty()) {
    return detail::open_file(folder.files.front());
  }
  return std::make_unique<detail::SeveralBags>(folder);
}

}  // namespace limber
