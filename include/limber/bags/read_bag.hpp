// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "limber/bags/bag_topics.hpp"
#include "limber/datasets/recording.hpp"

namespace limber {

/// @brief A recording from a bag. Its images stay in the bag until they are asked for.
///
/// Times are the stamps of the headers. Samples that arrived out of order are sorted, repeated ones left out,
/// and `notes` says how many. Left and right images need not have the very same stamps: each left image goes
/// with the nearest right one, and a constant difference of a millisecond or more becomes part of
/// StereoCalibration::time_offset_s. Poses and odometry are taken for those of the body.
///
/// @param calibration  of the cameras; a width and height of 0 are the images' own. With body kCam0 the bag's
///                     IMU is left out: nothing says where it sits
/// @param asked        topics; what is empty is proposed by propose_topics
/// @throws DataError if the bag cannot be read, a topic is missing or of another type, images have another
/// size
///         than the calibration says or change it, a clock jumps back by more than a second, or there is no
///         stereo pair at all
[[nodiscard]] Recording read_bag(const std::filesystem::path& path, const StereoCalibration& calibration,
                                 const std::optional<ImuNoise>& imu_noise, const BagTopics& asked = {},
                                 const std::function<void(std::size_t)>& progress = {});

}  // namespace limber
