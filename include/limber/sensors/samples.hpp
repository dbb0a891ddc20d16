// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <unordered_set>
#include <vector>

/// What sensors deliver. All times are integers in nanoseconds of one clock.
namespace limber {

/// One inertial sample, in the IMU frame.
struct ImuSample {
  /// [ns]
  std::int64_t t_ns = 0;
  Eigen::Vector3d omega_imu = Eigen::Vector3d::Zero();  ///< angular rate [rad/s]
  Eigen::Vector3d accel_imu = Eigen::Vector3d::Zero();  ///< specific force [m/s^2], +9.81 upwards at rest
};

/// One body-frame velocity and rate sample (wheels, or any odometer).
struct OdometrySample {
  /// [ns]
  std::int64_t t_ns = 0;
  Eigen::Vector3d v_body = Eigen::Vector3d::Zero();      ///< velocity in the body frame [m/s]
  Eigen::Vector3d omega_body = Eigen::Vector3d::Zero();  ///< angular rate [rad/s]
};

/// One point in one stereo frame, raw (distorted) pixels. At least one camera has seen it.
struct StereoObservation {
  /// the same number for the same point, from frame to frame
  std::int64_t track_id = 0;
  Eigen::Vector2d uv_cam0 = Eigen::Vector2d::Zero();  ///< [px], meaningful only if in_cam0
  Eigen::Vector2d uv_cam1 = Eigen::Vector2d::Zero();  ///< [px], meaningful only if in_cam1
  /// the left camera has seen it
  bool in_cam0 = true;
  /// the right camera has seen it
  bool in_cam1 = true;
};

/// All points of one stereo frame; each track_id at most once. May be empty.
struct StereoFrame {
  /// [ns], of the stamp; both images have the same
  std::int64_t t_ns = 0;
  /// in no order
  std::vector<StereoObservation> observations;
  bool put_back = false;  ///< the images came exchanged; the points are of those put back
  /// Tracks that were found out with this frame to be no points of the world: what earlier frames say of them
  /// is not to be used, where that can still be helped
  std::vector<std::int64_t> withdrawn = {};
};

/// Leaves what the frame holds of these tracks out.
void remove_tracks(StereoFrame& frame, const std::unordered_set<std::int64_t>& tracks);
/// ... what the earlier frames hold of those that `frame` withdraws.
void withdraw_from(std::vector<StereoFrame>& earlier, const StereoFrame& frame);

/// @throws std::invalid_argument, which names the track, for a pixel that is not finite or a million pixels
/// away
void check_points(const StereoFrame& frame);

/// Full state as a recording's ground truth gives it. Velocity and biases may be unknown.
struct GroundTruthState {
  /// [ns]
  std::int64_t t_ns = 0;
  /// attitude of the body
  Eigen::Matrix3d R_world_body = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p_world_body = Eigen::Vector3d::Zero();  ///< [m]
  Eigen::Vector3d v_world_body = Eigen::Vector3d::Zero();  ///< [m/s], in the world frame
  Eigen::Vector3d bias_gyro = Eigen::Vector3d::Zero();     ///< [rad/s]
  Eigen::Vector3d bias_accel = Eigen::Vector3d::Zero();    ///< [m/s^2]
};

}  // namespace limber
