// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "limber/bags/bag_contents.hpp"
#include "source_folder.hpp"

/// What the scripts in fixtures/ put into each of their files.
namespace limber::testing {

inline constexpr std::int64_t kStart = 1'600'000'000'123'456'789;  // [ns]
inline constexpr std::int64_t kFrameInterval = 50'000'000, kImuInterval = 5'000'000, kDelay = 10'000'000;
inline constexpr int kFixtureWidth = 16, kFixtureHeight = 12;
inline constexpr std::size_t kFixtureFrames = 5, kFixtureImu = 41;

inline std::filesystem::path fixture(const std::string& name) {
  return source_folder() / "tests" / "bags" / "fixtures" / name;
}

/// All sound files: each format and compression, made by other people's writers.
inline std::vector<std::string> sound_fixtures() {
  return {"ros1_none.bag",       "ros1_bz2.bag", "ros1_lz4.bag", "unchunked.mcap",    "chunked.mcap",
          "zstd.mcap",           "lz4.mcap",     "ros2.db3",     "ros2_messages.db3", "ros2_file.db3.zstd",
          "packed_messages.mcap"};
}

inline std::uint8_t fixture_pixel(int u, int v, std::size_t frame, int camera) {
  return static_cast<std::uint8_t>(7 * u + 13 * v + 31 * static_cast<int>(frame) + 101 * camera);
}

inline const BagStream& stream_of(const BagContents& contents, const std::string& topic) {
  for (const BagStream& stream : contents.streams) {
    if (stream.topic.name == topic) {
      return stream;
    }
  }
  throw std::runtime_error("no topic " + topic);
}

}  // namespace limber::testing
