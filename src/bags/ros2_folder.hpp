// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace limber::detail {

/// The folder of a ROS 2 bag.
struct Ros2Folder {
  std::vector<std::filesystem::path> files;  ///< in their order
  std::vector<std::string> missing;          ///< listed by metadata.yaml, but not there: in words
  std::vector<std::string> remarks;          ///< in words
};

/// Whether a folder has a metadata.yaml that lists files of a bag, or files that begin like one.
[[nodiscard]] bool is_ros2_folder(const std::filesystem::path& folder);

/// @brief The files that metadata.yaml lists (relative_file_paths); without one, or without such a list, all
/// that begin like a bag, by name.
/// @throws DataError (metadata.yaml) for a compression that is not read, and for names outside the folder
[[nodiscard]] Ros2Folder ros2_folder(const std::filesystem::path& folder);

}  // namespace limber::detail
