// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <optional>

#include "io/numbers.hpp"
#include "limber/bags/bag_file.hpp"
#include "limber/core/errors.hpp"
#include "mcap_records.hpp"
#include "openers.hpp"
#include "ros1_records.hpp"

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
};
constexpr std::array<Format, 3> kFormats = {
    {{ros1::kMagic, open_ros1_bag}, {mcap::kMagic, open_mcap}, {"SQLite format 3\0"sv, open_sqlite_bag}}};

std::string beginning_of(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) {
    return {};
  }
  std::ifstream stream(path, std::ios::binary);
  std::string out(16, '\0');
  stream.read(out.data(), static_cast<std::streamsize>(out.size()));
  out.resize(static_cast<std::size_t>(stream.gcount()));
  return out;
}

const Format* format_of(const fs::path& path) {
  const std::string beginning = beginning_of(path);
  const auto found = std::find_if(kFormats.begin(), kFormats.end(),
                                  [&](const Format& format) { return beginning.starts_with(format.magic); });
  return found == kFormats.end() ? nullptr : &*found;
}

/// "name_10.db3" comes after "name_9.db3".
bool in_order(const fs::path& a, const fs::path& b) {
  const std::string x = a.stem().string(), y = b.stem().string();
  return x.size() != y.size() ? x.size() < y.size() : x < y;
}

std::vector<fs::path> files_of_ros2_bag(const fs::path& folder) {
  std::vector<fs::path> out;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string ending = entry.path().extension().string();
    if ((ending == ".db3" || ending == ".mcap") && format_of(entry.path()) != nullptr) {
      out.push_back(entry.path());
    }
  }
  std::sort(out.begin(), out.end(), in_order);
  return out;
}

std::unique_ptr<BagFile> open_file(const fs::path& path) {
  if (const Format* format = format_of(path)) {
    return format->open(path);
  }
  const std::string found = beginning_of(path);
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
  explicit SeveralBags(const std::vector<fs::path>& paths) {
    for (const fs::path& path : paths) {
      bags_.push_back(open_file(path));
    }
  }

  void walk(const Wanted& wanted, const Visitor& visitor) override {
    topics_.clear();
    damages_.clear();
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
  [[nodiscard]] std::string format() const override {
    return fmt::format("{} of {} files", bags_.front()->format(), bags_.size());
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

  std::vector<std::unique_ptr<BagFile>> bags_;
  std::vector<BagTopic> topics_;
  std::vector<std::string> damages_;
};

}  // namespace
}  // namespace detail

bool is_bag(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_directory(path, error)) {
    return detail::format_of(path) != nullptr;
  }
  // An EuRoC folder stays one when somebody puts its bag beside it.
  return !std::filesystem::exists(path / "mav0", error) && !detail::files_of_ros2_bag(path).empty();
}

std::unique_ptr<BagFile> open_bag(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_directory(path, error)) {
    return detail::open_file(path);
  }
  const auto files = detail::files_of_ros2_bag(path);
  if (files.empty()) {
    throw DataError(path.string(), 0, "the folder of a ROS 2 bag, with .db3 or .mcap files", "none of them");
  }
  if (files.size() == 1) {
    return detail::open_file(files.front());
  }
  return std::make_unique<detail::SeveralBags>(files);
}

}  // namespace limber
