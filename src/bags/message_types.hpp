// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

#include "limber/bags/bag_file.hpp"

/// Types of the messages that limber writes.
namespace limber::detail {

struct MessageType {
  std::string_view name;  ///< "sensor_msgs/Imu"
  std::string_view md5;   ///< of ROS 1's definition, as ROS 1 computes it
};

namespace types {
inline constexpr MessageType kImage{"sensor_msgs/Image", "060021388200f6f0f447d0fcd9c64743"};
inline constexpr MessageType kCompressedImage{"sensor_msgs/CompressedImage",
                                              "8f7a12909da2c9d3332d540a0977563f"};
inline constexpr MessageType kImu{"sensor_msgs/Imu", "6a62c6daae103f4ff57a132d6f95cec2"};
inline constexpr MessageType kTwistStamped{"geometry_msgs/TwistStamped", "98d34b0043a2093cf9d9345ab6eef12e"};
inline constexpr MessageType kOdometry{"nav_msgs/Odometry", "cd5e73d190d741a2f92e81eda573aca7"};
inline constexpr MessageType kPoseStamped{"geometry_msgs/PoseStamped", "d3812c3cbc69362b77dc0b19b345f8f5"};
inline constexpr MessageType kVector3Stamped{"geometry_msgs/Vector3Stamped",
                                             "7b324c7325e683bf02a9b14b01090ec7"};
inline constexpr MessageType kPath{"nav_msgs/Path", "6227e2b7e9cce15051f669a5e197bbf7"};
inline constexpr MessageType kPointCloud2{"sensor_msgs/PointCloud2", "1158d486dd51d683ce2f1be655c3c181"};
inline constexpr MessageType kTfMessage{"tf2_msgs/TFMessage", "94810edda583a504dfda3829e70d7eec"};
inline constexpr MessageType kDiagnosticArray{"diagnostic_msgs/DiagnosticArray",
                                              "60810da900de1dd6ddd437c3503511da"};
}  // namespace types

/// @brief The text of a message definition with all that it is made of, without comments.
/// @param type           one of `types`
/// @param serialization  kRos1: ROS 1's; kCdr: ROS 2's (encoding "ros2msg" in MCAP files)
[[nodiscard]] std::string definition_of(const MessageType& type, Serialization serialization);

/// The name of a type in its own world: "sensor_msgs/Imu", in ROS 2 "sensor_msgs/msg/Imu".
[[nodiscard]] std::string full_name(const MessageType& type, Serialization serialization);

}  // namespace limber::detail
