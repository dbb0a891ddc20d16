// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "limber/core/covariance.hpp"
#include "limber/core/pose.hpp"

/// @file
/// The state, its error and its layout; said once, here.
///
/// Error state: true = estimate ⊕ error. Additive for positions, velocities, biases, landmark values and
/// parameters of the calibration; attitude local: R_true = R_est Exp(dtheta), dtheta [rad] in the body frame.
/// Order: position, attitude, then what the motion model adds, then parameters beyond theta, then theta (of
/// both, what is estimated or considered), then the witness of the calibration monitor (if any;
/// limber/update/witness.hpp), then the scale of the map (if no frame tells it), then that of odometry (if it
/// is in doubt), then steps of the biases (if they are supposed), then the triplets of the map in no
/// particular order (anchors: a position and an attitude triplet; landmarks: one).
namespace limber {

/// What drives the prediction, and so what the state holds beside the pose.
enum class MotionModel : std::uint8_t {
  kImu,               ///< velocity (world), gyro bias, accelerometer bias
  kConstantVelocity,  ///< velocity (world), angular rate (body)
  kOdometry           ///< nothing: body velocity and rate are inputs
};

/// IMU and odometry show how long a metre is; a constant-velocity model does not.
[[nodiscard]] inline bool has_scale(MotionModel motion) { return motion != MotionModel::kConstantVelocity; }

/// Mean of the body's state. Fields that the motion model does not use stay as they are.
struct NavigationState {
  /// [ns]
  std::int64_t t_ns = 0;
  /// of the body in the world
  Pose T_world_body;
  Eigen::Vector3d v_world_body = Eigen::Vector3d::Zero();  ///< [m/s], in the world frame
  Eigen::Vector3d omega_body = Eigen::Vector3d::Zero();    ///< [rad/s], constant velocity only
  Eigen::Vector3d bias_gyro = Eigen::Vector3d::Zero();     ///< [rad/s]
  Eigen::Vector3d bias_accel = Eigen::Vector3d::Zero();    ///< [m/s^2]
};

/// Indices of the error state's leading blocks.
struct StateLayout {
  /// what drives the prediction
  MotionModel motion = MotionModel::kImu;
  /// theta is estimated, or its uncertainty carried
  bool has_theta = false;
  /// see docs/derivations/witness.md
  bool has_witness = false;
  std::array<bool, 3> has_more{};  ///< parameters of cam0, cam1, mount (limber/sensors/parameters.hpp)
  /// No frame tells a common factor of all lengths (one camera, or a baseline that is constrained): its
  /// error is in the state, so that no update learns it by chance (Estimate::retract).
  bool has_map_scale = false;
  /// Odometry's speeds may be long or short by a constant factor: considered, never corrected. kOdometry
  /// only.
  bool has_odometry_scale = false;
  /// Steps of the biases and of the clock that nobody believes in: what they would have done to everything
  /// else is carried along in the covariance (Estimate::suppose_steps). kImu only.
  bool has_supposed_steps = false;

  /// of the position error, world axes [m]
  static constexpr Eigen::Index kPosition = 0;
  /// of the attitude error, body axes [rad]
  static constexpr Eigen::Index kAttitude = 3;
  /// of the velocity error [m/s]: kImu, kConstantVelocity
  static constexpr Eigen::Index kVelocity = 6;  // IMU, constant velocity
  /// of the rate error [rad/s]: kConstantVelocity
  static constexpr Eigen::Index kRate = 9;  // constant velocity
  /// of the gyro bias error [rad/s]: kImu
  static constexpr Eigen::Index kBiasGyro = 9;  // IMU
  /// of the accelerometer bias error [m/s^2]: kImu
  static constexpr Eigen::Index kBiasAccel = 12;  // IMU
  /// position and attitude
  static constexpr Eigen::Index kPoseSize = 6;

  /// Size of the body's error state: 15 (IMU), 12 (constant velocity) or 6 (odometry).
  [[nodiscard]] Eigen::Index body_size() const {
    switch (motion) {
      case MotionModel::kImu:
        return 15;
      case MotionModel::kConstantVelocity:
        return 12;
      case MotionModel::kOdometry:
        break;
    }
    return 6;
  }
  /// Start of the k-th of has_more (six wide), valid only if it is there.
  [[nodiscard]] Eigen::Index more(std::size_t k) const {
    return body_size() + 6 * std::count(has_more.begin(), has_more.begin() + k, true);
  }
  /// Start of theta (six wide), valid only if has_theta.
  [[nodiscard]] Eigen::Index theta() const { return more(has_more.size()); }
  /// Start of the witness (six wide), valid only if has_witness.
  [[nodiscard]] Eigen::Index witness() const { return theta() + (has_theta ? 6 : 0); }
  /// Start of the map's scale, valid only if has_map_scale: a triplet of which the first entry counts, the
  /// error of the logarithm [-]; the others are nothing.
  [[nodiscard]] Eigen::Index map_scale() const { return witness() + (has_witness ? 6 : 0); }
  /// Start of the odometry's scale, valid only if has_odometry_scale: a triplet of which the first entry
  /// counts, the error of the factor [-]; the others are nothing.
  [[nodiscard]] Eigen::Index odometry_scale() const { return map_scale() + (has_map_scale ? kTriplet : 0); }
  /// Start of the steps of gyro bias [rad/s], accelerometer bias [m/s^2] and clock, valid only if
  /// has_supposed_steps: three triplets, of the last of which the first entry counts, how much later than
  /// taken samples are stamped [s]; the others are nothing.
  [[nodiscard]] Eigen::Index supposed_steps() const {
    return odometry_scale() + (has_odometry_scale ? kTriplet : 0);
  }
  /// The clock's step among them.
  [[nodiscard]] Eigen::Index clock_step() const { return supposed_steps() + 2 * kTriplet; }
  /// Start of the map.
  [[nodiscard]] Eigen::Index map_begin() const {
    return supposed_steps() + (has_supposed_steps ? 3 * kTriplet : 0);
  }
};

/// @brief The body's pose at the initialisation of some landmarks, a clone that stays in the state while they
/// need it.
struct Anchor {
  /// of the body when it was cloned
  Pose T_world_body;
  Pose T_body_cam0;                               ///< a number fixed at initialisation, not part of the state
  Eigen::Index position_at = 0, attitude_at = 0;  ///< their triplets in the error state
  int users = 0;                                  ///< landmarks that stand on it; 0: free to reuse
  bool passive = false;                           ///< its triplets are rows of the passive block
};

/// How a landmark's triplet is to be read.
enum class LandmarkKind : std::uint8_t {
  kInverseDepth,  ///< (a, b, rho): X_cam0_at_initialization = R_cam0_chart (a, b, 1) / rho, rho [1/m]
  kCartesian      ///< p_world_landmark [m]
};

/// One point of the map.
struct Landmark {
  /// as in StereoObservation
  std::int64_t track_id = 0;
  /// how `value` is to be read
  LandmarkKind kind = LandmarkKind::kInverseDepth;
  /// the triplet
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  Eigen::Matrix3d R_cam0_chart =
      Eigen::Matrix3d::Identity();  ///< its third axis is the bearing at initialisation
  int anchor = -1;                  ///< index of its anchor; kInverseDepth only
  Eigen::Index at = 0;              ///< its triplet in the error state
  bool passive = false;             ///< `at` is a row of the passive block
  double rho_assumed =
      0.0;  ///< inverse depth at initialisation if the right pixel under a doubtful theta gave it, else 0
  bool depth_guessed = false;  ///< the left camera alone has seen it: its inverse depth began as a prior
  /// time of the last frame that saw it [ns]
  std::int64_t last_seen_ns = 0;
  int refusals = 0;   ///< frames in a row in which it was refused
  int sightings = 0;  ///< frames since its initialisation in which it was not
};

}  // namespace limber
