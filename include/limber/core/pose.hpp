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

  [[nodiscard]] Pose inverse() const;
  [[nodiscard]] Eigen::Vector3d operator*(const Eigen::Vector3d& point) const;
  [[nodiscard]] Pose operator*(const Pose& other) const;
};

/// The pose a share s of the way from a to b, along the line and the shortest rotation (slerp); s below 0 or
/// above 1 continues that motion.
[[nodiscard]] Pose interpolate(const Pose& a, const Pose& b, double s);

/// A pose with its time: `T_world_body` at `t_ns` [ns].
struct StampedPose {
  std::int64_t t_ns = 0;
  Pose T_world_body;
};

}  // namespace limber
