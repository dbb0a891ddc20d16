// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>

#include "limber/datasets/recording.hpp"

namespace limber {

/// What becomes of an image on its way; empty: it stays as it is stored.
using ImageChange = std::function<EncodedImage(EncodedImage, const std::string& place)>;

/// @brief Writes a recording with images as an MCAP file: ROS 2 messages (CDR), indexed chunks of zstd.
///
/// | topic | type |
/// | --- | --- |
/// | /camN/image_raw, /camN/image_raw/compressed (image files) | sensor_msgs Image, CompressedImage |
/// | /imu0 | sensor_msgs/Imu, without orientation |
/// | /odometry | geometry_msgs/TwistStamped, of the body |
/// | /groundtruth | nav_msgs/Odometry, of the body; velocity zero where unknown |
///
/// Images, IMU, odometry and stamps keep every bit. Both images of a pair get its time. Biases of the ground
/// truth, the calibration and the noise have no place in it. Appears complete or not at all.
/// @param progress  told the pairs done; may be empty
/// @param stop      asked before every pair: true ends the work by std::runtime_error; may be empty
/// @throws DataError if the file cannot be written
/// @throws std::invalid_argument if the recording has no images, or times before 1970 or after 2038
void write_mcap(const Recording& recording, const std::filesystem::path& path, const ImageChange& change = {},
                const std::function<void(std::size_t)>& progress = {},
                const std::function<bool()>& stop = {});

}  // namespace limber
