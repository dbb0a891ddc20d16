// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "limber/state/estimate.hpp"

namespace limber::python {

/// What is known of the body at a time.
struct State {
  NavigationState nav;
  Eigen::MatrixXd covariance;
};

inline Eigen::MatrixXd body_covariance(const Estimate& estimate) {
  const Eigen::Index size = estimate.layout().body_size();
  return estimate.P().block(0, 0, size, size);
}

}  // namespace limber::python
