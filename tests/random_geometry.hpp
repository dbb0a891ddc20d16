// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <random>

#include "limber/core/pose.hpp"
#include "limber/core/so3.hpp"

/// Random geometry for property tests; the seed is the generator the test owns.
namespace limber::testing {

using Generator = std::mt19937_64;

/// Uniform in [low, high).
inline double random_scalar(Generator& generator, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(generator);
}

/// Each coordinate uniform in [-bound, bound).
inline Eigen::Vector3d random_vector(Generator& generator, double bound) {
  const double x = random_scalar(generator, -bound, bound);
  const double y = random_scalar(generator, -bound, bound);
  return {x, y, random_scalar(generator, -bound, bound)};
}

/// Uniform direction.
inline Eigen::Vector3d random_direction(Generator& generator) {
  Eigen::Vector3d v = random_vector(generator, 1.0);
  while (v.norm() > 1.0 || v.norm() < 0.1) {
    v = random_vector(generator, 1.0);
  }
  return v.normalized();
}

/// Uniform direction, angle uniform in [0, max_angle) [rad].
inline Eigen::Matrix3d random_rotation(Generator& generator, double max_angle = 3.14) {
  const Eigen::Vector3d axis = random_direction(generator);
  return so3_exp(random_scalar(generator, 0.0, max_angle) * axis);
}

/// Any attitude, position within `bound` [m] along each axis.
inline Pose random_pose(Generator& generator, double bound) {
  const Eigen::Matrix3d R = random_rotation(generator);
  return {R, random_vector(generator, bound)};
}

}  // namespace limber::testing
