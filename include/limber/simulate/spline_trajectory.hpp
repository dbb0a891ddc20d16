// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "limber/core/pose.hpp"

namespace limber {

/// Pose of the body and its derivatives at one instant.
struct Kinematics {
  /// of the body
  Pose T_world_body;
  Eigen::Vector3d v_world_body = Eigen::Vector3d::Zero();  ///< velocity, in the world frame [m/s]
  Eigen::Vector3d a_world_body = Eigen::Vector3d::Zero();  ///< acceleration, in the world frame [m/s^2]
  Eigen::Vector3d omega_body = Eigen::Vector3d::Zero();    ///< angular rate, in the body frame [rad/s]
};

/// @brief What an ideal accelerometer in the body reads: R^T (a + g e_z) [m/s^2], the world being z up.
[[nodiscard]] Eigen::Vector3d specific_force(const Kinematics& state, double gravity);

/// @brief Trajectory as a continuous function of time: uniform cubic B-spline, twice continuously
/// differentiable in position and (cumulative form) in attitude, so that sensors can be read off it exactly.
///
/// Control pose i sits at (i - 1) `knot_spacing` after the rest. The spline stays in the convex hull of four
/// neighbours: speed never exceeds the longest step between neighbours divided by the spacing, angular rate
/// likewise.
/// @note [Sommer2020].
class SplineTrajectory {
 public:
  /// @param control_poses at least four; neighbours less than pi apart
  /// @param knot_spacing  [s], positive
  /// @param rest          [s], not negative: stands where it begins for so long; smooth where the first three
  ///                      control poses are the same
  /// @throws std::invalid_argument otherwise
  SplineTrajectory(std::vector<Pose> control_poses, double knot_spacing, double rest = 0.0);

  /// The spline is defined on [0, duration()] [s].
  [[nodiscard]] double duration() const;

  /// @throws std::invalid_argument if t [s] is outside [0, duration()]
  [[nodiscard]] Kinematics at(double t) const;

  /// Of the spline, `knot_spacing` apart.
  [[nodiscard]] const std::vector<Pose>& control_poses() const { return control_poses_; }

 private:
  std::vector<Pose> control_poses_;
  std::vector<Eigen::Vector3d> rotation_steps_;  // Log(R_i^T R_{i+1})
  double knot_spacing_;
  double rest_;
};

}  // namespace limber
