// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "limber/core/pose.hpp"
#include "limber/datasets/ground_truth.hpp"
#include "limber/sensors/samples.hpp"

/// Files that hold a trajectory. Every reader throws DataError (file, line, expected, found) for what it
/// cannot use: wrong number of columns, numbers that are not finite, times that do not increase, quaternions
/// far from unit norm, matrices that are no rotation, no pose at all. Every writer goes through AtomicFile.
namespace limber {

/// What a trajectory file looks like.
enum class TrajectoryFormat {
  kTum,               ///< t [s] tx ty tz qx qy qz qw
  kKittiPoses,        ///< 12 numbers a line, the upper 3x4 of T_world_cam0, no time
  kEurocGroundTruth,  ///< EuRoC's state_groundtruth_estimate0/data.csv
  kLimber             ///< limber's trajectory.csv
};

/// Poses of a file.
struct Trajectory {
  /// that the content showed
  TrajectoryFormat format = TrajectoryFormat::kTum;
  bool has_time = true;            ///< false: StampedPose::t_ns is the index of the pose (KITTI)
  std::vector<StampedPose> poses;  ///< strictly increasing time, at least one
};

/// Reads any of the formats; the content tells which.
[[nodiscard]] Trajectory read_trajectory(const std::filesystem::path& path);

/// TUM format. Times keep every digit down to 1 ns. Lines of 14 or 20 columns (OpenVINS: covariances) are
/// read too, without those columns.
[[nodiscard]] std::vector<StampedPose> read_tum(const std::filesystem::path& path);
/// Writes poses as `t x y z qx qy qz qw`, seconds and metres. @throws DataError if the file cannot be written
void write_tum(const std::filesystem::path& path, const std::vector<StampedPose>& poses);

/// KITTI odometry poses, turned from KITTI's camera-like world (x right, y down, z forward) to z up:
/// T_world_cam0 = R_zup_kitti * T_file, so that the identity looks along x. Times are indices. Rotations are
/// as printed (about six digits), as evo takes them.
[[nodiscard]] std::vector<StampedPose> read_kitti_poses(const std::filesystem::path& path);
/// The way back: the poses as they are, without their times, in KITTI's world.
void write_kitti_poses(const std::filesystem::path& path, const std::vector<StampedPose>& poses);

/// Reads a ground truth of EuRoC. @throws DataError naming file and line
[[nodiscard]] GroundTruth read_euroc_groundtruth(const std::filesystem::path& path);

/// Writes the columns that are known; the format has none for biases alone, so with them the velocity is
/// written, too. @throws std::invalid_argument if times do not increase or a number is not finite
/// @throws DataError if the file cannot be written
void write_euroc_groundtruth(const std::filesystem::path& path, const GroundTruth& truth);

/// One line of trajectory.csv. What is unknown is an empty cell.
struct TrajectoryRow {
  /// [ns]
  std::int64_t t_ns = 0;
  /// of the body in the world
  Pose T_world_body;
  std::optional<Eigen::Vector3d> v_world_body;  ///< [m/s]
  std::optional<Eigen::Vector3d> bias_gyro;     ///< [rad/s]
  std::optional<Eigen::Vector3d> bias_accel;    ///< [m/s^2]
  /// Covariance of (position in world [m], attitude error dtheta in the body frame [rad]), symmetric.
  std::optional<Eigen::Matrix<double, 6, 6>> covariance;
  /// Standard deviations of v_world_body [m/s], bias_gyro [rad/s] and bias_accel [m/s^2], axis by axis.
  std::optional<Eigen::Vector3d> sigma_v, sigma_bias_gyro, sigma_bias_accel;
};

/// Times and poses alone.
[[nodiscard]] std::vector<StampedPose> poses_of(const std::vector<TrajectoryRow>& rows);
/// The same of a ground truth.
[[nodiscard]] std::vector<StampedPose> poses_of(const std::vector<GroundTruthState>& states);

/// trajectory.csv: a header line with names and units, then t_ns, position, quaternion (w x y z), velocity,
/// gyro and accelerometer bias, the upper triangle of the covariance, row by row, and the standard deviations
/// of velocity and biases (47 columns; older files end with the covariance, 38 columns).
[[nodiscard]] std::vector<TrajectoryRow> read_trajectory_csv(const std::filesystem::path& path);

/// @throws std::invalid_argument if times do not increase or a number is not finite
/// @throws DataError if the file cannot be written
void write_trajectory_csv(const std::filesystem::path& path, const std::vector<TrajectoryRow>& rows);

}  // namespace limber
