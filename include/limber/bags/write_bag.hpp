// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "limber/datasets/recording.hpp"

namespace limber {

/// What becomes of an image on its way; empty: it stays as it is stored.
using ImageChange = std::function<EncodedImage(EncodedImage, const std::string& place)>;

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
/// @param progress  told the pairs done; may be empty
/// @param stop      asked before every pair: true ends the work by std::runtime_error; may be empty
/// @throws DataError if the file cannot be written
/// @throws std::invalid_argument if the recording has no images, times before 1970 or after 2038 (2106 in
///         ROS 1), or for a compression that the format has not
void write_bag(const Recording& recording, const BagOutput& output, const ImageChange& change = {},
               const std::function<void(std::size_t)>& progress = {}, const std::function<bool()>& stop = {});

}  // namespace limber
