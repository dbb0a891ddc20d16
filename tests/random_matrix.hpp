// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <random>

#include "limber/core/covariance.hpp"
#include "random_geometry.hpp"

/// Random matrices and places in them.
namespace limber::testing {

/// Uniform in [low, high].
inline Eigen::Index random_index(Generator& generator, Eigen::Index low, Eigen::Index high) {
  return std::uniform_int_distribution<Eigen::Index>(low, high)(generator);
}

/// Where some triplet of `size` scalars begins.
inline Eigen::Index random_triplet(Generator& generator, Eigen::Index size) {
  return kTriplet * random_index(generator, 0, size / kTriplet - 1);
}

/// Each element uniform in [-1, 1).
inline Eigen::MatrixXd random_matrix(Generator& generator, Eigen::Index rows, Eigen::Index cols) {
  return Eigen::MatrixXd::NullaryExpr(rows, cols, [&] { return random_scalar(generator, -1.0, 1.0); });
}

}  // namespace limber::testing
