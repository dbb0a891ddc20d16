// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "limber/core/linear_measurement.hpp"

namespace limber {

/// @brief A measurement whose points are turned: what no state moves lies apart.
///
/// A point that two cameras see has four rows, which depend on all states through three numbers: where it
/// stands in the body frame. An orthogonal change of its rows leaves one that no state moves; it is the
/// epipolar constraint, which looks at theta alone, unless theta is a state.
struct TurnedMeasurement {
  /// Without groups: three rows of each such point and all of the others, then the fourth rows, if most are
  /// moved by the same states (theta); if no state moves them they are the stateless rows. Whitened (sigma =
  /// 1), if there is any such point.
  LinearMeasurement rows;
  /// where the rows of each group of the measurement are
  std::vector<RowGroup> groups;
  /// q×k: the columns of H that the last q rows see; empty where the fourth rows are stateless
  Eigen::MatrixXd seen_by_fourth;
};

/// @brief Turns the rows of each group that has four and a point of its own.
/// @note [MourikisRoumeliotis2007], section III-D.
[[nodiscard]] TurnedMeasurement turned(const LinearMeasurement& z);

}  // namespace limber
