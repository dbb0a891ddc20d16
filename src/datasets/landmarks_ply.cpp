// SPDX-License-Identifier: MIT
#include "limber/datasets/landmarks_ply.hpp"

#include <fmt/format.h>

#include <iterator>
#include <limits>
#include <stdexcept>

#include "limber/datasets/atomic_file.hpp"

namespace limber {

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
