// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "blocks.hpp"
#include "limber/smooth/smoother.hpp"

namespace limber::detail {

/// What all pixels and inputs up to a frame say of it: the marginal that a later problem begins with. Points
/// are not in it; a problem that begins with it must not use the frame's pixels again.
struct KnownState {
  NavigationState nav;
  RigParameters theta = RigParameters::Zero();
  Eigen::Matrix<double, kMoreParameters, 1> more = Eigen::Matrix<double, kMoreParameters, 1>::Zero();
  /// Of pose, motion, theta (if it is one with that of later frames) and the free ones of `more`, in this
  /// order.
  Eigen::MatrixXd covariance;
  std::int64_t origin_ns = 0;  ///< where the first piece of a rig began
};

/// Whether a frame's theta says something of the next frame's.
[[nodiscard]] inline bool outlives_a_frame(RigModel rig) {
  return rig != RigModel::kTrusted && rig != RigModel::kFree;
}

}  // namespace limber::detail
