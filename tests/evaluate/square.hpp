// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <numbers>
#include <vector>

#include "limber/core/so3.hpp"
#include "limber/evaluate/association.hpp"

/// Trajectories small enough to evaluate on paper.
namespace limber::testing {

inline constexpr double kDegree = std::numbers::pi / 180.0;

inline Eigen::Matrix3d yaw_rotation(double degrees) {
  return so3_exp(degrees * kDegree * Eigen::Vector3d::UnitZ());
}

/// The i-th of poses that are 0.1 s apart.
inline MatchedPose matched(std::size_t i, const Pose& estimate, const Pose& truth) {
  return {static_cast<std::int64_t>(i) * 100'000'000, i, estimate, truth};
}

/// The corners of the unit square in the ground plane, looking along x; the truth is the same square, twice
/// as large, turned by 90 degrees about z and moved to (10, 0, 5).
inline std::vector<MatchedPose> square() {
  const std::vector<Eigen::Vector3d> corners = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  std::vector<MatchedPose> poses;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Matrix3d R = yaw_rotation(90.0);
    const Pose truth{R, 2.0 * (R * corners[i]) + Eigen::Vector3d(10.0, 0.0, 5.0)};
    poses.push_back(matched(i, {Eigen::Matrix3d::Identity(), corners[i]}, truth));
  }
  return poses;
}

}  // namespace limber::testing
