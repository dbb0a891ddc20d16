// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "limber/datasets/recording.hpp"

/// The readers behind read_recording, one per format. They fill everything but name and path.
namespace limber::detail {

/// Calibration and everything optional of an EuRoC folder: all but tracks and images.
[[nodiscard]] Recording read_euroc_common(const std::filesystem::path& mav0);

[[nodiscard]] Recording read_track_log(const std::filesystem::path& mav0);
[[nodiscard]] Recording read_euroc_images(const std::filesystem::path& mav0);
[[nodiscard]] Recording read_kitti_odometry(const std::filesystem::path& folder);

[[nodiscard]] Recording read_kitti_raw(const std::filesystem::path& folder);

/// @brief Times that are all too close for nanoseconds are micro- or milliseconds.
/// @param shortest_ns  between two of them, of any such sensor; their median is compared
/// @throws DataError for `file`; not of fewer than ten
void require_nanoseconds(const std::vector<std::int64_t>& t_ns, std::int64_t shortest_ns,
                         const std::filesystem::path& file);
inline constexpr std::int64_t kShortestFrame_ns = 200'000;

/// The true rig over time, as a table of time [ns], ax, ay, az [rad], tx, ty, tz [m].
[[nodiscard]] std::vector<TrueRig> read_calibration_truth(const std::filesystem::path& file);

/// From KITTI's world (the first left camera: x right, y down, z forward) to one with z up that it looks
/// along x.
[[nodiscard]] Eigen::Matrix3d R_zup_kitti();

}  // namespace limber::detail
