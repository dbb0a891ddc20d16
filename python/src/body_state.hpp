// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "limber/state/state.hpp"

namespace limber::python {

/// What is known of the body at a time.
struct State {
  NavigationState nav;
  Eigen::MatrixXd covariance;
};

}  // namespace limber::python
