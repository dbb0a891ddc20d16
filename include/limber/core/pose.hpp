// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "limber/core/so3.hpp"

namespace limber {

/// Rigid transform `T_a_b`: maps b-coordinates to a, p_a = R_a_b p_b + p_a_b.
struct Pose {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  ///< R_a_b
  Eigen::Vector3d p = Eigen::Vector3d::Zero();      ///< origin of b in a [m]

  /// T_b_a.
  [[nodiscard]] Pose inverse() const;
  /// p_a of a point p_b.
  [[nodiscard]] Eigen::Vector3d operator*(const Eigen::Vector3d& point) const;
  /// T_a_c of another T_b_c.
  [[nodiscard]] Pose operator*(const Pose& other) const;
  /// member by member
  bool operator==(const Pose&) const = default;
};

/// The pose a share s of the way from a to b, along the line and the shortest rotation (slerp); s below 0 or
/// above 1 continues that motion.
[[nodiscard]] Pose interpolate(const Pose& a, const Pose& b, double s);

/// A pose with its time: `T_world_body` at `t_ns` [ns].
struct StampedPose {
  /// [ns]
  std::int64_t t_ns = 0;
  /// of the body in the world
  Pose T_world_body;
};

}  // namespace limber
