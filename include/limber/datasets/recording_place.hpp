// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <set>

/// Which places are those of recordings: asked by the writers, and by programs before long work.
namespace limber {

/// @brief Whether the folder is one of a recording by what lies in it: what read_recording recognises, a day
/// of KITTI raw drives, or the list of a ROS 2 bag (metadata.yaml). Bag files alone do not make it one.
/// @return false also for what is no folder, or none that can be looked into
[[nodiscard]] bool holds_recording(const std::filesystem::path& folder);

/// Whether a folder is an EuRoC mav0 or lies in one, seen through links.
[[nodiscard]] bool lies_in_mav0(const std::filesystem::path& folder);

/// What a KITTI odometry folder holds, by name; what else lies there is no part of the recording.
[[nodiscard]] const std::set<std::filesystem::path>& names_in_kitti_folder();

/// @brief For write_track_log and write_euroc: `folder` holds no mav0 yet, or an empty one, and lies in none.
/// @param replace  an older mav0 that limber wrote may be there, too
/// @throws DataError
void require_place_for_mav0(const std::filesystem::path& folder, bool replace);

/// @brief For recordings that are made as a whole folder: there is none of this name yet, or an empty one.
/// @param replace  a folder may be there, too, that holds a recording by limber, and beside it nothing else
/// @throws DataError
void require_place_for_recording(const std::filesystem::path& folder, bool replace);

}  // namespace limber
