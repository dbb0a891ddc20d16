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

}  // namespace limber
