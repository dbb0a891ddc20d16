// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <map>

namespace limber {

/// @brief Writes points as ASCII PLY with the vertex properties x, y, z (float, [m]) and id (int; double if
/// an id needs more than 32 bits), in order of id. Goes through AtomicFile.
/// @param landmarks track_id -> p_world_landmark [m]
/// @throws std::invalid_argument if a coordinate is not finite
/// @throws DataError if the file cannot be written
void write_landmarks_ply(const std::filesystem::path& path,
                         const std::map<std::int64_t, Eigen::Vector3d>& landmarks);

/// @brief Reads what write_landmarks_ply wrote: ASCII PLY whose vertices have x, y, z and id, in any order
/// and among others.
/// @throws DataError (file, line) if the file is something else, a number is not finite or an id comes twice
[[nodiscard]] std::map<std::int64_t, Eigen::Vector3d> read_landmarks_ply(const std::filesystem::path& path);

}  // namespace limber
