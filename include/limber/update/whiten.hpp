// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

namespace limber {

/// @brief X := X L⁻ᵀ: columns that had the covariance L Lᵀ become independent ones of unit variance.
///
/// The half of an update that is neither the factor nor the product W Wᵀ. Halved again and again, so that all
/// but blocks of eight columns is a matrix product; at the sizes of a map that is a fifth faster than Eigen's
/// triangular solve from the right.
/// @param L       m×m, its lower triangle is read; diagonal not zero
/// @param[in,out] X  n×m
void whiten_columns(const Eigen::Ref<const Eigen::MatrixXd>& L, Eigen::Ref<Eigen::MatrixXd> X);

}  // namespace limber
