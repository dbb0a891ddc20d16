// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

namespace limber::detail {

/// Mallows' weights [Maronna2006]: what moves a point across its line grows with its disparity, and that of a
/// wrong match is anything. Its derivatives are, too, and a few such rows fit themselves, whatever their
/// residuals were. So no row has more influence than one whose derivatives are four times the usual ones,
/// the medians of a column's magnitudes.
/// @param J  a row each, of one kind: n×k, not empty
/// @return n weights, 0 to 1: the least over columns of (limit / |J|)²
[[nodiscard]] Eigen::VectorXd lever_weights(const Eigen::MatrixXd& J);

}  // namespace limber::detail
