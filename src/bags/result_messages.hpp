// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "limber/bags/bag_file.hpp"
#include "limber/bags/write_results.hpp"

/// Results as ROS messages: of frame "world", the body is "body".
namespace limber::detail {

using MessageBytes = std::vector<std::uint8_t>;

/// nav_msgs/Path, stamped with the first pose. @param poses  at least one
[[nodiscard]] MessageBytes path_message(const std::vector<StampedPose>& poses, Serialization serialization);
/// geometry_msgs/PoseStamped
[[nodiscard]] MessageBytes pose_message(const StampedPose& pose, Serialization serialization);
/// tf2_msgs/TFMessage
[[nodiscard]] MessageBytes transform_message(const TrajectoryRow& row, Serialization serialization);
/// nav_msgs/Odometry
[[nodiscard]] MessageBytes odometry_message(const TrajectoryRow& row, Serialization serialization);
/// geometry_msgs/Vector3Stamped in the body frame
[[nodiscard]] MessageBytes vector_message(std::int64_t t_ns, const Eigen::Vector3d& v,
                                          Serialization serialization);
/// sensor_msgs/PointCloud2
[[nodiscard]] MessageBytes map_message(std::int64_t t_ns,
                                       const std::map<std::int64_t, Eigen::Vector3d>& landmarks,
                                       Serialization serialization);
/// diagnostic_msgs/DiagnosticArray
[[nodiscard]] MessageBytes diagnostic_message(const Diagnostic& diagnostic, Serialization serialization);

}  // namespace limber::detail
