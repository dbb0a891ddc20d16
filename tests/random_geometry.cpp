// SPDX-License-Identifier: MIT
#include "random_geometry.hpp"

namespace limber::testing {

double random_scalar(Generator& generator, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(generator);
}

Eigen::Vector3d random_vector(Generator& generator, double bound) {
  const double x = random_scalar(generator, -bound, bound);
  const double y = random_scalar(generator, -bound, bound);
  return {x, y, random_scalar(generator, -bound, bound)};
}

Eigen::Vector3d random_direction(Generator& generator) {
  Eigen::Vector3d v = random_vector(generator, 1.0);
  while (v.norm() > 1.0 || v.norm() < 0.1) {
    v = random_vector(generator, 1.0);
  }
  return v.normalized();
}

Eigen::Matrix3d random_rotation(Generator& generator, double max_angle) {
  const Eigen::Vector3d axis = random_direction(generator);
  return so3_exp(random_scalar(generator, 0.0, max_angle) * axis);
}

Pose random_pose(Generator& generator, double bound) {
  const Eigen::Matrix3d R = random_rotation(generator);
  return {R, random_vector(generator, bound)};
}

}  // namespace limber::testing
