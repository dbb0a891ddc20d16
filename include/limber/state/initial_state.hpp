// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "limber/state/initial_sigma.hpp"
#include "limber/state/state.hpp"

namespace limber {

/// Where to start.
struct InitialState {
  NavigationState nav;
  Eigen::MatrixXd body_covariance;  ///< StateLayout::body_size() wide
};

/// An initial state with uncorrelated, isotropic uncertainty.
[[nodiscard]] InitialState make_initial_state(const NavigationState& nav, MotionModel motion,
                                              const InitialSigma& sigma);

}  // namespace limber
