// SPDX-License-Identifier: MIT
#include "limber/datasets/landmarks_ply.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "io/numbers.hpp"
#include "io/text_file.hpp"
#include "limber/core/errors.hpp"
#include "limber/io/atomic_file.hpp"

namespace limber {
namespace {

/// Walks through an ASCII PLY file line by line, word by word.
class PlyReader {
 public:
  explicit PlyReader(std::filesystem::path path)
      : path_(std::move(path)), stream_(detail::load_text(path_)) {}

  /// The words of the next line.
  std::vector<std::string> next(const std::string& expected) {
    std::string line;
    ++line_;
    if (!std::getline(stream_, line)) {
      fail(expected, "the end of the file");
    }
    std::istringstream words(line);
    return {std::istream_iterator<std::string>(words), {}};
  }

  [[noreturn]] void fail(const std::string& expected, const std::string& found) const {
    throw DataError(path_.string(), line_, expected, found);
  }

 private:
  std::filesystem::path path_;
  std::istringstream stream_;
  std::size_t line_ = 0;
};

/// How many vertices there are, and in which columns x, y, z and id stand.
struct PlyHeader {
  std::size_t vertices = 0, columns = 0;
  std::array<std::size_t, 4> column{};
};

PlyHeader read_header(PlyReader& file) {
  if (file.next("'ply'") != std::vector<std::string>{"ply"}) {
    file.fail("a PLY file", "another first line");
  }
  PlyHeader header;
  std::vector<std::string> properties;
  for (auto words = file.next("a PLY header"); words != std::vector<std::string>{"end_header"};
       words = file.next("'end_header'")) {
    if (words.size() == 3 && words[0] == "element" && words[1] == "vertex") {
      const auto count = detail::parse_integer(words[2]);
      if (!count || *count < 0) {
        file.fail("a number of vertices", detail::excerpt(words[2]));
      }
      header.vertices = static_cast<std::size_t>(*count);
    } else if (words.size() == 3 && words[0] == "property") {
      properties.push_back(words[2]);
    } else if (!words.empty() && words[0] == "format" && (words.size() < 2 || words[1] != "ascii")) {
      file.fail("format ascii", "another format");
    }
  }
  header.columns = properties.size();
  constexpr std::array kNames = {"x", "y", "z", "id"};
  for (std::size_t k = 0; k < kNames.size(); ++k) {
    const auto it = std::find(properties.begin(), properties.end(), kNames[k]);
    if (it == properties.end()) {
      file.fail(fmt::format("a vertex property '{}'", kNames[k]), "a header without it");
    }
    header.column[k] = static_cast<std::size_t>(it - properties.begin());
  }
  return header;
}

}  // namespace

std::map<std::int64_t, Eigen::Vector3d> read_landmarks_ply(const std::filesystem::path& path) {
  PlyReader file(path);
  const PlyHeader header = read_header(file);
  std::map<std::int64_t, Eigen::Vector3d> landmarks;
  for (std::size_t k = 0; k < header.vertices; ++k) {
    const std::vector<std::string> words = file.next(fmt::format("{} vertices", header.vertices));
    if (words.size() != header.columns) {
      file.fail(fmt::format("{} columns", header.columns), std::to_string(words.size()));
    }
    std::array<double, 4> values{};
    for (std::size_t n = 0; n < values.size(); ++n) {
      const std::string& word = words[header.column[n]];
      values[n] = detail::parse_number(word).value_or(std::numeric_limits<double>::quiet_NaN());
      if (!std::isfinite(values[n])) {
        file.fail("a finite number", detail::excerpt(word));
      }
    }
    const auto id = detail::parse_integer(words[header.column[3]]);
    if (!id || !landmarks.try_emplace(*id, values[0], values[1], values[2]).second) {
      file.fail("a track id that did not come before", detail::excerpt(words[header.column[3]]));
    }
  }
  return landmarks;
}

void write_landmarks_ply(const std::filesystem::path& path,
                         const std::map<std::int64_t, Eigen::Vector3d>& landmarks) {
  using Int32 = std::numeric_limits<std::int32_t>;
  const bool ids_fit = landmarks.empty() || (landmarks.begin()->first >= Int32::min() &&
                                             landmarks.rbegin()->first <= Int32::max());
  fmt::memory_buffer text;
  fmt::format_to(std::back_inserter(text),
                 "ply\nformat ascii 1.0\ncomment landmarks in the world frame [m], id = track_id\n"
                 "element vertex {}\nproperty float x\nproperty float y\nproperty float z\nproperty {} id\n"
                 "end_header\n",
                 landmarks.size(), ids_fit ? "int" : "double");
  for (const auto& [id, p_world_landmark] : landmarks) {
    const Eigen::Vector3f p = p_world_landmark.cast<float>();
    if (!p.allFinite()) {
      throw std::invalid_argument(fmt::format("write_landmarks_ply: landmark {} is not finite", id));
    }
    fmt::format_to(std::back_inserter(text), "{} {} {} {}\n", p.x(), p.y(), p.z(), id);
  }
  write_file_atomically(path, {text.data(), text.size()});
}

}  // namespace limber
