// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "limber/core/linear_measurement.hpp"

namespace limber {

/// What is left of an innovation without some of its groups.
struct KeptRows {
  std::vector<Eigen::Index> moved;      ///< rows of S, in order
  std::vector<Eigen::Index> stateless;  ///< of the stateless rows, in order
  std::vector<RowGroup> groups;         ///< those that are kept, where they lie among these rows
};

/// @param kept       one flag per group
/// @param moved      rows of S
/// @param stateless  rows behind them
[[nodiscard]] KeptRows kept_rows(const std::vector<RowGroup>& groups, const std::vector<bool>& kept,
                                 Eigen::Index moved, Eigen::Index stateless);

}  // namespace limber
