// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <random>

#include "limber/core/pose.hpp"
#include "limber/core/so3.hpp"

/// Random geometry for property tests; the seed is the generator the test owns. Two draws in the arguments of
/// one call come in an order of the compiler's: draw them one by one, or in braces.
namespace limber::testing {

using Generator = std::mt19937_64;

/// Uniform in [low, high).
double random_scalar(Generator& generator, double low, double high);

/// Each coordinate uniform in [-bound, bound).
Eigen::Vector3d random_vector(Generator& generator, double bound);

/// Uniform direction.
Eigen::Vector3d random_direction(Generator& generator);

/// Uniform direction, angle uniform in [0, max_angle) [rad].
Eigen::Matrix3d random_rotation(Generator& generator, double max_angle = 3.14);

/// Any attitude, position within `bound` [m] along each axis.
Pose random_pose(Generator& generator, double bound);

}  // namespace limber::testing
