// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "limber/datasets/image_files.hpp"

namespace limber {

/// Files of messages that limber writes.
enum class BagFormat {
  kMcap,  ///< MCAP with ROS 2 messages (CDR)
  kRos1   ///< ROS 1 bag, format 2.0
};

/// How the chunks of a format can be compressed, the default first.
[[nodiscard]] std::span<const std::string_view> compressions_of(BagFormat format);

/// A file of messages to write.
struct BagOutput {
  /// of the file to write
  std::filesystem::path path;
  /// of the file to write
  BagFormat format = BagFormat::kMcap;
  std::string compression;  ///< one of compressions_of(format); empty: the default
};

/// @brief Writes a recording with images as messages in indexed chunks.
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
/// An image that cannot be read, or changed, is left out, the other of its pair is not.
/// @param progress  told the pairs done; may be empty
/// @param stop      asked before every pair: true ends the work by std::runtime_error; may be empty
/// @return what was left out
/// @throws DataError if the file cannot be written, or the first kFirstPairs images of a camera, or all,
///         cannot be read
/// @throws std::invalid_argument if the recording has no images, times before 1970 or after 2038 (2106 in
///         ROS 1), or for a compression that the format has not
std::vector<LostImage> write_bag(const Recording& recording, const BagOutput& output,
                                 const ImageChange& change = {},
                                 const std::function<void(std::size_t)>& progress = {},
                                 const std::function<bool()>& stop = {});

}  // namespace limber
