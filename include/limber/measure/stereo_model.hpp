// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <optional>

#include "limber/measure/rig.hpp"
#include "limber/sensors/parameters.hpp"
#include "limber/state/state.hpp"

namespace limber {

/// @brief A landmark seen from the body, in homogeneous form: its position is Y / w.
/// Cartesian landmarks have w = 1, inverse-depth ones w = rho, so that far points need no special case.
struct BodyPoint {
  /// [m], or the bearing in the body frame where w is the inverse depth
  Eigen::Vector3d Y = Eigen::Vector3d::UnitZ();
  /// 1, or the inverse depth rho [1/m]
  double w = 1.0;
  Eigen::Matrix3d J_Y_position, J_Y_attitude;  ///< of the body
  Eigen::Matrix3d J_Y_landmark;                ///< of the landmark's triplet
  /// zero for Cartesian landmarks
  Eigen::RowVector3d J_w_landmark;
  Eigen::Matrix3d J_Y_anchor_position = Eigen::Matrix3d::Zero();  ///< zero for Cartesian landmarks
  /// zero for Cartesian landmarks
  Eigen::Matrix3d J_Y_anchor_attitude = Eigen::Matrix3d::Zero();
};

/// @brief The landmark in the body frame at pose T_world_body, with derivatives with respect to the error
/// state.
/// @param anchor  the landmark's anchor; null for a Cartesian landmark
[[nodiscard]] BodyPoint body_point(const Pose& T_world_body, const Landmark& landmark, const Anchor* anchor);

/// @brief The same at the time at which a camera took its image, with derivatives with respect to the pose at
/// the stamp. The body moves as mounted.motion says.
[[nodiscard]] BodyPoint body_point_at_exposure(const MountedCamera& mounted, const Pose& T_world_body,
                                               const Landmark& landmark, const Anchor* anchor);

/// @brief Position of the landmark in the world [m]; far away but finite where the inverse depth is not
/// positive.
[[nodiscard]] Eigen::Vector3d world_position(const Landmark& landmark, const Anchor* anchor);

/// Pixel of a landmark in one camera and its derivatives.
struct PointProjection {
  Eigen::Vector2d uv;  ///< [px]
  /// of the body; of the landmark's triplet [px per m, rad, unit of the triplet]
  Eigen::Matrix<double, 2, 3> J_position, J_attitude, J_landmark;
  Eigen::Matrix<double, 2, 3> J_anchor_position, J_anchor_attitude;  ///< inverse depth only
  Eigen::Matrix<double, 2, 6> J_theta;  ///< zero if the camera does not depend on theta
  /// Parameters beyond theta, in their order; only if the camera was mounted with_parameters.
  std::optional<Eigen::Matrix<double, 2, kMoreParameters>> J_more;
  /// The body's velocity (world) and rate (body); only if the camera has a time offset.
  struct MotionJacobians {
    /// [px s/m], [px s/rad]
    Eigen::Matrix<double, 2, 3> velocity, rate;
  };
  /// nothing without a time offset
  std::optional<MotionJacobians> J_motion;
  /// Of what the landmark's error owes to that of the map's scale: see Estimate::refer_to_epoch.
  std::optional<Eigen::Vector2d> J_map_scale;
};

/// @brief Projects a body point into one camera of the rig.
/// @return nothing where the camera model is not valid (behind the camera)
/// @note [Vivet2022], Eqs. (22)-(28) as corrected.
[[nodiscard]] std::optional<PointProjection> project_point(const MountedCamera& mounted,
                                                           const BodyPoint& point);

}  // namespace limber
