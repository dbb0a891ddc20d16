// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <string_view>
#include <vector>

#include "limber/bags/diagnostic.hpp"
#include "limber/bags/write_bag.hpp"
#include "limber/core/pose.hpp"
#include "limber/datasets/trajectory_files.hpp"

namespace limber {

/// The topic of a run's poses, in a bag that write_results made.
inline constexpr std::string_view kOdometryOfRun = "/limber/odometry";

/// What came of a run.
struct RunResults {
  /// one row a frame, in order of time
  std::vector<TrajectoryRow> trajectory;
  std::vector<StampedPose> truth;                     ///< in the world of the trajectory; may be empty
  std::map<std::int64_t, Eigen::Vector3d> landmarks;  ///< track_id -> p_world_landmark [m]; may be empty
  std::vector<Diagnostic> diagnostics;                ///< in order of time; may be empty
};

/// The covariance of a row's pose as ROS has it: of position and rotation about the axes of the world, in
/// which R_true = Exp(dtheta) R_est; zeros where the row has none.
[[nodiscard]] Eigen::Matrix<double, 6, 6> ros_pose_covariance(const TrajectoryRow& row);

/// @brief Writes results as messages that Foxglove and rviz show, in the frame "world".
///
/// | topic | type |
/// | --- | --- |
/// | /tf | tf2_msgs/TFMessage, world to body |
/// | /limber/odometry | nav_msgs/Odometry of the body, with the covariance of the pose |
/// | /limber/bias/gyro, /limber/bias/accel | geometry_msgs/Vector3Stamped, where they are known |
/// | /limber/path, /groundtruth/path | nav_msgs/Path, whole, at the first time |
/// | /groundtruth | geometry_msgs/PoseStamped |
/// | /limber/map | sensor_msgs/PointCloud2 (x, y, z), the final map at the first time |
/// | /diagnostics | diagnostic_msgs/DiagnosticArray |
///
/// The covariance is turned to ROS's: attitude about the axes of the world. The odometry's twist has the
/// velocity in the body frame, zeros for the rates and for its covariance, which the results do not hold; a
/// pose without covariance has zeros, too. Appears complete or not at all.
/// @throws DataError if the file cannot be written
/// @throws std::invalid_argument without a pose, for times as write_bag, or for a compression that the format
///         has not
void write_results(const RunResults& results, const BagOutput& output);

}  // namespace limber
