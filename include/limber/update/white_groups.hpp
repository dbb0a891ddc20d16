// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "limber/core/linear_measurement.hpp"

namespace limber {

/// Rows group by group, in units of the standard deviations that each group has for itself.
struct WhiteGroups {
  Eigen::VectorXd r;             ///< m
  Eigen::MatrixXd A;             ///< m×k
  std::vector<RowGroup> groups;  ///< where they are here: one behind the other, without a fourth row apart
};

/// @brief r, and A, in units of each group's own S.
/// @param r       m
/// @param S       n×n, n <= m: covariance of the first n rows; that of the others is the identity
/// @param A       m×k, k may be zero
/// @param groups  partition of the rows
[[nodiscard]] WhiteGroups white_groups(const Eigen::VectorXd& r, const Eigen::MatrixXd& S,
                                       const Eigen::MatrixXd& A, const std::vector<RowGroup>& groups);

/// The rows of X that belong to a group, its fourth last.
[[nodiscard]] Eigen::MatrixXd rows_of(const RowGroup& group, const Eigen::MatrixXd& X);

}  // namespace limber
