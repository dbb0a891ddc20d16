// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>

#include "limber/bags/bag_file.hpp"

/// The formats behind open_bag.
namespace limber::detail {

[[nodiscard]] std::unique_ptr<BagFile> open_ros1_bag(const std::filesystem::path& path);
[[nodiscard]] std::unique_ptr<BagFile> open_mcap(const std::filesystem::path& path);
[[nodiscard]] std::unique_ptr<BagFile> open_sqlite_bag(const std::filesystem::path& path);

/// Whether a file begins like a bag, or like one that zstd has packed.
[[nodiscard]] bool begins_like_bag(const std::filesystem::path& path);

/// Without ROS 2's "/msg/": "sensor_msgs/msg/Imu" is "sensor_msgs/Imu".
[[nodiscard]] std::string without_msg(std::string type);

/// "ros1" and "cdr"; all else is kOther.
[[nodiscard]] Serialization serialization_from(const std::string& name);

}  // namespace limber::detail
